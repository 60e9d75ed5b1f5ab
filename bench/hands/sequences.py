"""Test sequences: gestures of a body and of separately captured hands, as noisy points, with the true alignment."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.files import clip_files
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.motion.roles import SIDES, find_roles
from motionsplice.motion.skeleton import Integers
from motionsplice.precompute.hands.banded_warp import FramePair
from motionsplice.precompute.hands.phases import derivatives
from motionsplice.precompute.hands.points import HandMotion, hand_motion

RATE, NOISE = 60.0, 0.002
FEWEST, MOST = 6, 34  # gestures
SHORTEST, LONGEST = 280 / RATE, 570 / RATE  # seconds
SIZES = 0.2, 1.0  # of the hands' gestures, relative to the body's
SLOWEST, FASTEST, TEMPO_CHANGES = 0.6, 1.6, 1.2  # slowest and fastest tempo, and seconds between tempo changes
SETTLED = 4  # frames from the end of a stroke to its pair, so that the pair is not on the seam of the repetition


class Sequence(NamedTuple):
    """The hands of a body and of a hands clip, and the true frame of the hands clip for each frame [F] of the body."""

    body: list[HandMotion]
    hands: list[HandMotion]
    truth: Floats
    moving: NDArray[np.bool_]  # [F] whether any hand of the body moves


def sequence(seed: int, size: tuple[float, float] = SIZES) -> Sequence:
    """Draws gestures like the paper's, as noisy points. `size`: range of the hands' size relative to the body's."""
    draw = np.random.default_rng([seed, 1])
    gestures, seconds = int(draw.integers(FEWEST, MOST + 1)), float(draw.uniform(SHORTEST, LONGEST))
    pair = gesture_pair(seed, gestures=gestures, seconds=seconds, amplitude=size)
    moves = np.zeros(pair.body.frame_count, np.bool_)
    for span in pair.spans:
        if span.kind != "hold":
            moves[int(np.ceil(span.begin)) : int(span.end) + 1] = True
    return Sequence(noisy(hands_of(pair.body), draw), noisy(hands_of(pair.hands), draw), pair.hand_frames, moves)


def hands_of(clip: Clip) -> list[HandMotion]:
    """Returns the motion of both hands of a clip."""
    roles = find_roles(clip.skeleton)
    return [hand_motion(clip, roles, side) for side in SIDES]


def noisy(hands: list[HandMotion], draw: np.random.Generator) -> list[HandMotion]:
    """Adds noise with a standard deviation of NOISE metres to all points."""
    return [replace(hand, points=hand.points + draw.normal(0.0, NOISE, hand.points.shape)) for hand in hands]


def captured(clips: Path) -> list[Sequence]:
    """The arms of each clip, and a copy of them as if captured separately: smaller, turned and in another tempo."""
    sequences = []
    for number, file in enumerate(clip_files(clips)):
        reading, draw = read_clip(file), np.random.default_rng([number, 3])
        clip = reading.clip.frames(1, reading.clip.frame_count).resampled(RATE)  # the first frame may be a T-pose
        clip = clip.frames(0, min(clip.frame_count, round(LONGEST * RATE)))
        body = [hand_motion(clip, reading.roles, side) for side in SIDES]
        knots = np.arange(0.0, clip.duration + 2.0 * TEMPO_CHANGES, TEMPO_CHANGES) * RATE
        tempo = np.exp(draw.uniform(np.log(SLOWEST), np.log(FASTEST), len(knots)))
        frames = np.arange(clip.frame_count)
        truth = np.asarray(PchipInterpolator(knots, tempo).antiderivative()(frames))
        read_at = np.interp(np.arange(int(truth[-1]) + 1), truth, frames)
        size, facing = float(draw.uniform(*SIZES)), float(draw.uniform(-np.pi, np.pi))
        hands = [transformed(hand, read_at, size, facing) for hand in body]
        sequences.append(
            Sequence(noisy(body, draw), noisy(hands, draw), truth, np.any([moving(hand) for hand in body], axis=0))
        )
    return sequences


def transformed(hand: HandMotion, frames: Floats, size: float, facing: float) -> HandMotion:
    """Samples a hand at real-valued `frames` [n], scales it about its mean, and turns it by `facing` about Y."""
    assert hand.trunk is not None
    points = CubicSpline(np.arange(len(hand.points)), hand.points)(frames)
    middle = points.mean(axis=0)
    turned = rotate(about([0.0, 1.0, 0.0], facing), middle + size * (points - middle))
    return HandMotion(turned, np.interp(frames, np.arange(len(hand.trunk)), hand.trunk) + facing)


def moving(hand: HandMotion) -> NDArray[np.bool_]:
    """Returns for each frame [F] whether any point of the hand moves."""
    found = derivatives(hand.points, RATE)
    return np.asarray((np.abs(found.velocity) > found.still).any(axis=(1, 2)))


def ambiguous(seed: int) -> tuple[Sequence, tuple[FramePair, ...], Integers]:
    """Draws counting gestures, some of which the hands make twice.

    Returns the sequence, three frame pairs, and the captured frame that each frame of the hands shows. The truth is in
    captured frames, so it does not matter which of the two repetitions an alignment chooses.
    """
    draw = np.random.default_rng([seed, 2])
    pair = gesture_pair(seed, kinds=["count"] * 6, seconds=7.0, hand="right", amplitude=(0.3, 0.6))
    strokes = np.array([span.end for span in pair.spans if span.kind == "stroke"])
    chosen = int(draw.integers(len(strokes) - 1))
    begin, end = pair.hand_frames[strokes[chosen : chosen + 2].round().astype(int)].round().astype(int).tolist()
    hands = pair.hands
    order = np.concatenate([np.arange(end), np.arange(begin, hands.frame_count)])
    twice = Clip("twice", hands.skeleton, hands.rate, hands.root_positions[order], hands.rotations[order])
    middle = max(chosen, 1)  # the second of three strokes around the repetition
    pairs = []
    for at in strokes[middle - 1 : middle + 2].round().astype(int) + SETTLED:
        hand_frame = pair.hand_frames[at]
        pairs.append(FramePair(int(at), round(hand_frame if hand_frame < end else hand_frame + end - begin), 2))
    body, repeated = noisy(hands_of(pair.body), draw)[1:], noisy(hands_of(twice), draw)[1:]
    return Sequence(body, repeated, pair.hand_frames, np.ones(len(pair.hand_frames), np.bool_)), tuple(pairs), order
