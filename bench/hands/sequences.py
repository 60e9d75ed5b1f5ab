"""Gestures of a body and of hands that were captured apart, whose true correspondence is known, as noisy points."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.files import clip_files, read_clip
from motionsplice.motion.hand_joints import SIDES
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.motion.roles import find_roles
from motionsplice.motion.skeleton import Integers
from motionsplice.precompute.hands.banded_warp import FramePair
from motionsplice.precompute.hands.phases import derivatives
from motionsplice.precompute.hands.points import HandMotion, hand_motion

RATE, NOISE = 60.0, 0.002
FEWEST, MOST = 6, 34  # gestures
SHORTEST, LONGEST = 280 / RATE, 570 / RATE  # seconds
SIZES = 0.2, 1.0  # of the hands', as parts of the body's
SLOWEST, FASTEST, TEMPO_CHANGES = 0.6, 1.6, 1.2  # tempi, and seconds from one to the next
SETTLED = 4  # frames after a stroke at which a pair is set, off the seam of the repetition


class Sequence(NamedTuple):
    """Both hands of a body and of a clip of hands, and the true frame [F] of the hands for each of the body's."""

    body: list[HandMotion]
    hands: list[HandMotion]
    truth: Floats
    moving: NDArray[np.bool_]  # [F] whether either hand of the body moves


def sequence(seed: int, size: tuple[float, float] = SIZES) -> Sequence:
    """Gestures like those of the paper, as noisy points."""
    draw = np.random.default_rng([seed, 1])
    gestures, seconds = int(draw.integers(FEWEST, MOST + 1)), float(draw.uniform(SHORTEST, LONGEST))
    pair = gesture_pair(seed, gestures=gestures, seconds=seconds, amplitude=size)
    moves = np.zeros(pair.body.frame_count, np.bool_)
    for span in pair.spans:
        if span.kind != "hold":
            moves[int(np.ceil(span.begin)) : int(span.end) + 1] = True
    return Sequence(noisy(hands_of(pair.body), draw), noisy(hands_of(pair.hands), draw), pair.hand_frames, moves)


def hands_of(clip: Clip) -> list[HandMotion]:
    roles = find_roles(clip.skeleton)
    return [hand_motion(clip, roles, side) for side in SIDES]


def noisy(hands: list[HandMotion], draw: np.random.Generator) -> list[HandMotion]:
    return [replace(one, points=one.points + draw.normal(0.0, NOISE, one.points.shape)) for one in hands]


def captured(clips: Path) -> list[Sequence]:
    """The arms of each clip, and once more as if captured apart: smaller, turned, and in another tempo."""
    found = []
    for number, file in enumerate(clip_files(clips)):
        reading, draw = read_clip(file), np.random.default_rng([number, 3])
        clip = reading.clip.frames(1, reading.clip.frame_count).resampled(RATE)  # the first may be no motion
        clip = clip.frames(0, min(clip.frame_count, round(LONGEST * RATE)))
        body = [hand_motion(clip, reading.roles, side) for side in SIDES]
        knots = np.arange(0.0, clip.duration + 2.0 * TEMPO_CHANGES, TEMPO_CHANGES) * RATE
        tempo = np.exp(draw.uniform(np.log(SLOWEST), np.log(FASTEST), len(knots)))
        frames = np.arange(clip.frame_count)
        truth = np.asarray(PchipInterpolator(knots, tempo).antiderivative()(frames))
        read = np.interp(np.arange(int(truth[-1]) + 1), truth, frames)
        size, facing = float(draw.uniform(*SIZES)), float(draw.uniform(-np.pi, np.pi))
        hands = [again(one, read, size, facing) for one in body]
        found.append(
            Sequence(noisy(body, draw), noisy(hands, draw), truth, np.any([moving(one) for one in body], axis=0))
        )
    return found


def again(hand: HandMotion, read: Floats, size: float, facing: float) -> HandMotion:
    """The hand as it is at real-valued frames [n], about its middle so many times as large, and turned about Y."""
    assert hand.trunk is not None
    points = CubicSpline(np.arange(len(hand.points)), hand.points)(read)
    middle = points.mean(axis=0)
    turned = rotate(about([0.0, 1.0, 0.0], facing), middle + size * (points - middle))
    return HandMotion(turned, np.interp(read, np.arange(len(hand.trunk)), hand.trunk) + facing)


def moving(hand: HandMotion) -> NDArray[np.bool_]:
    """Whether any point of it moves in each frame [F]."""
    found = derivatives(hand.points, RATE)
    return np.asarray((np.abs(found.velocity) > found.still).any(axis=(1, 2)))


def ambiguous(seed: int) -> tuple[Sequence, tuple[FramePair, ...], Integers]:
    """Counting, where the hands play one part twice; three pairs; and which captured frame each of the hands' is.

    The truth is in captured frames, for which of both performances is taken makes no difference.
    """
    draw = np.random.default_rng([seed, 2])
    pair = gesture_pair(seed, kinds=["count"] * 6, seconds=7.0, hand="right", amplitude=(0.3, 0.6))
    strokes = np.array([span.end for span in pair.spans if span.kind == "stroke"])
    chosen = int(draw.integers(len(strokes) - 1))
    begin, end = pair.hand_frames[strokes[chosen : chosen + 2].round().astype(int)].round().astype(int).tolist()
    hands = pair.hands
    order = np.concatenate([np.arange(end), np.arange(begin, hands.frame_count)])
    twice = Clip("twice", hands.skeleton, hands.rate, hands.root_positions[order], hands.rotations[order])
    middle = max(chosen, 1)  # of three strokes, before the repetition and after it
    pairs = []
    for at in strokes[middle - 1 : middle + 2].round().astype(int) + SETTLED:
        shown = pair.hand_frames[at]
        pairs.append(FramePair(int(at), round(shown if shown < end else shown + end - begin), 2))
    body, theirs = noisy(hands_of(pair.body), draw)[1:], noisy(hands_of(twice), draw)[1:]
    return Sequence(body, theirs, pair.hand_frames, np.ones(len(pair.hand_frames), np.bool_)), tuple(pairs), order
