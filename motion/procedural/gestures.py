"""Pairs of a body and separately captured hands that perform the same gestures, with a known truth.

Majkowska, Zordan and Faloutsos 2006 captured hands in a cube of 20 inches, and bodies without that limit. Here both
perform one score, each at its own tempo and size. Their tempi determine which frame of the hands belongs to which frame
of the body.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.procedural.actions import Upper, reaching_arm
from motionsplice.motion.procedural.body import LEFT, RIGHT
from motionsplice.motion.procedural.hand_rig import with_fingers
from motionsplice.motion.procedural.library import moving, standing
from motionsplice.motion.procedural.score import (
    EXTENSION,
    FINGERS,
    KINDS,
    PRONATION,
    REST,
    SIDES,
    WRIST,
    Kind,
    PhaseKind,
    Score,
    performed,
    phase_spans,
    write_score,
)
from motionsplice.motion.procedural.upper import Carriage, Rhythm, swinging_arm, trunk
from motionsplice.motion.quaternion import Floats

SLOWEST, FASTEST, TEMPO_CHANGES = 0.6, 1.6, 1.2  # relative tempo; seconds between random tempi
VOLUME = np.array([0.0, -0.28, 0.27])  # the wrist at rest where hands are captured, from the shoulder, metres
SMALLER = 0.95  # stature of the person whose hands are captured, relative to the body's
SAMPLE_HANDS = {"count_steps": "right", "directions": "both"}  # the gesturing hand of each sample
_ELBOW = (0.45, -1.0, -0.35)


@dataclass(frozen=True)
class Span:
    """A phase of a gesture, from frame `begin` to `end` of the body, real-valued. `side` is LEFT or RIGHT."""

    side: float
    kind: PhaseKind
    begin: float
    end: float


@dataclass(frozen=True, eq=False)
class GesturePair:
    """A body whose fingers do not move, separately captured hands, and the true result of combining them.

    truth:       the body with its own fingers moving.
    hand_frames: [F] the real-valued frame of `hands` that belongs to each frame of `body`.
    kinds:       the gestures in order.
    spans:       the phases of the body's gestures.
    """

    body: Clip
    hands: Clip
    truth: Clip
    hand_frames: Floats
    kinds: list[Kind]
    spans: list[Span]


def gesture_pair(
    seed: int,
    *,
    kinds: list[Kind] | None = None,
    gestures: int = 8,
    seconds: float = 7.0,
    rate: float = 60.0,
    hand_rate: float = 60.0,
    amplitude: tuple[float, float] = (0.2, 0.6),
    locomotion: str | None = "walk",
    hand: str = "both",
) -> GesturePair:
    """Generates a pair that performs gestures of the given `kinds`, or `gestures` random ones.

    seconds:         duration of the body's clip. rate, hand_rate: frames per second of the body and of the hands.
    amplitude:       range of the size of the hands' gestures relative to the body's.
    locomotion:      the body's locomotion, or None to stand.
    hand:            "left", "right" or "both"; raises SettingsError for anything else.
    """
    if hand not in SIDES:
        raise SettingsError(f"unknown hand {hand!r}", mend=f"Choose one of {', '.join(SIDES)}")
    random = np.random.default_rng([seed, 7])
    drawn = [KINDS[int(number)] for number in random.integers(0, len(KINDS), gestures)]
    score = write_score(random, kinds if kinds is not None else drawn, SIDES[hand])
    body_time = _reading(random, score, seconds, rate)
    hand_time = _reading(random, score, seconds * random.uniform(0.85, 1.2), hand_rate)
    place = VOLUME + random.uniform(-0.03, 0.03, 3)
    own = _channels(score, body_time, REST[WRIST], np.ones(len(score.kinds)))
    small = _channels(score, hand_time, place, random.uniform(*amplitude, len(score.kinds)))
    _vary(small, score, hand_time, random)
    lasting = (len(body_time) - 1) / rate
    if locomotion is None:
        body = standing("body", lambda c, r: _upper(c, r, own), lasting, rate, random.uniform(-np.pi, np.pi))
    else:
        body = moving("body", locomotion, lambda c, r: _upper(c, r, own), lasting, rate, seed)
    facing = random.uniform(-np.pi, np.pi)
    hands = standing("hands", lambda c, r: _upper(c, r, small), (len(hand_time) - 1) / hand_rate, hand_rate, facing)
    hands = with_fingers(hands, {side: channels[:, FINGERS] for side, channels in small.items()})
    hands = replace(hands, skeleton=hands.skeleton.scaled(SMALLER), root_positions=SMALLER * hands.root_positions)
    truth = with_fingers(replace(body, name="truth"), {side: channels[:, FINGERS] for side, channels in own.items()})
    frames = np.arange(len(body_time), dtype=np.float64)
    spans = [
        Span(side, kind, *np.interp([begin, end], body_time, frames).tolist())
        for side, moves in score.moves.items()
        for kind, begin, end in phase_spans(moves, score.seconds)
    ]
    hand_frames = np.interp(body_time, hand_time, np.arange(len(hand_time), dtype=np.float64))
    return GesturePair(with_fingers(body), hands, truth, hand_frames, score.kinds, spans)


def _reading(random: np.random.Generator, score: Score, seconds: float, rate: float) -> Floats:
    """Returns the time in the score [F] that a performer, whose tempo varies smoothly, has reached in each frame."""
    time = np.arange(round(seconds * rate) + 1) / rate
    knots = np.arange(0.0, seconds + 2.0 * TEMPO_CHANGES, TEMPO_CHANGES)
    tempo = np.exp(random.uniform(np.log(SLOWEST), np.log(FASTEST), len(knots)))
    read = np.asarray(PchipInterpolator(knots, tempo).antiderivative()(time))
    return read * (score.seconds / read[-1])


def _channels(score: Score, time: Floats, place: Floats, sizes: Floats) -> dict[float, Floats]:
    """Returns the motion [F, CHANNELS] of each side's hand, with each gesture of the score scaled by its size."""
    return {side: performed(moves, REST, place, sizes, time) for side, moves in score.moves.items()}


def _vary(channels: dict[float, Floats], score: Score, time: Floats, random: np.random.Generator) -> None:
    """Varies a performance: wrists by about a centimetre, palms by a few degrees."""
    knots = np.linspace(0.0, score.seconds, 2 + round(score.seconds))
    for hand in channels.values():
        deviations = random.normal(size=(len(knots), 5)) * [0.008, 0.008, 0.008, 0.06, 0.06]
        hand[:, :5] += PchipInterpolator(knots, deviations)(np.clip(time, 0.0, score.seconds))


def _upper(carriage: Carriage, rhythm: Rhythm, channels: dict[float, Floats]) -> Upper:
    """Returns the chest, which twists less than in plain walking, and the arms: gesturing, or else swinging."""
    arms = {side: swinging_arm(carriage, rhythm, side) for side in (LEFT, RIGHT)}
    for side, hand in channels.items():
        palm = {"pronation": hand[:, PRONATION], "extension": hand[:, EXTENSION]}
        arms[side] = reaching_arm(side, hand[:, WRIST], _ELBOW, **palm)
    return trunk(replace(carriage, twist=0.6 * carriage.twist), rhythm), arms


def sample_gestures() -> dict[str, Clip]:
    """Returns the sample gestures by name: for each of SAMPLE_HANDS, a walking body and its hands."""
    found = {}
    for name, seed, kinds in (
        ("count_steps", 11, ["count"] * 5),
        ("directions", 12, ["point", "point", "open_close", "wave", "point", "thumbs_up"]),
    ):
        hand = SAMPLE_HANDS[name]
        pair = gesture_pair(seed, kinds=kinds, hand=hand, seconds=1.5 * len(kinds))  # type: ignore[arg-type]
        found[name] = replace(pair.body, name=name)
        found[f"{name}_hands"] = replace(pair.hands, name=f"{name}_hands")
    return found
