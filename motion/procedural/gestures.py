"""The same gestures by a body and by hands that were captured apart: in other times and sizes, so the truth is known.

Majkowska, Zordan and Faloutsos 2006 captured hands in a cube of 20 inches, and bodies without such a limit. What both
do is a score; which frame of the hands goes with which of the body follows from when each of them reads it.
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

SLOWEST, FASTEST, TEMPO_CHANGES = 0.6, 1.6, 1.2  # of the score's time; seconds from one drawn tempo to the next
VOLUME = np.array([0.0, -0.28, 0.27])  # where hands are captured: their wrist at rest, from the shoulder
SMALLER = 0.95  # the stature of whose hands are captured
SAMPLE_HANDS = {"count_steps": "right", "directions": "both"}  # bodies that gesture, and by which hand
_ELBOW = (0.45, -1.0, -0.35)


@dataclass(frozen=True)
class Span:
    """A phase of a gesture, in real-valued frames of the body."""

    side: float
    kind: PhaseKind
    begin: float
    end: float


@dataclass(frozen=True, eq=False)
class GesturePair:
    """A body without fingers' motion, hands of their own, and what both together should be.

    hand_frames: [F] the real-valued frame of `hands` that goes with each of `body`. truth: the body whose own fingers
    move. spans: the phases of the body's gestures.
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
    """Gestures of `kinds`, or so many drawn ones, within `seconds` of the body's time.

    amplitude: how large each of the hands' gestures is, as a part of the body's, is drawn from this. locomotion: what
    the body does meanwhile; None: it stands. hand: `left`, `right` or `both`. Raises SettingsError for another.
    """
    if hand not in SIDES:
        raise SettingsError(f"there is no hand {hand!r}", mend=f"Choose one of {', '.join(SIDES)}")
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
    hands = with_fingers(hands, {side: one[:, FINGERS] for side, one in small.items()})
    hands = replace(hands, skeleton=hands.skeleton.scaled(SMALLER), root_positions=SMALLER * hands.root_positions)
    truth = with_fingers(replace(body, name="truth"), {side: one[:, FINGERS] for side, one in own.items()})
    frames = np.arange(len(body_time), dtype=np.float64)
    spans = [
        Span(side, kind, *np.interp([begin, end], body_time, frames).tolist())
        for side, moves in score.moves.items()
        for kind, begin, end in phase_spans(moves, score.seconds)
    ]
    hand_frames = np.interp(body_time, hand_time, np.arange(len(hand_time), dtype=np.float64))
    return GesturePair(with_fingers(body), hands, truth, hand_frames, score.kinds, spans)


def _reading(random: np.random.Generator, score: Score, seconds: float, rate: float) -> Floats:
    """When a performer reads the score [F]: its time in each frame, at a tempo that changes smoothly."""
    time = np.arange(round(seconds * rate) + 1) / rate
    knots = np.arange(0.0, seconds + 2.0 * TEMPO_CHANGES, TEMPO_CHANGES)
    tempo = np.exp(random.uniform(np.log(SLOWEST), np.log(FASTEST), len(knots)))
    read = np.asarray(PchipInterpolator(knots, tempo).antiderivative()(time))
    return read * (score.seconds / read[-1])


def _channels(score: Score, time: Floats, place: Floats, sizes: Floats) -> dict[float, Floats]:
    """What each side's hand does [F, CHANNELS] as the score has it, but for the size of each gesture."""
    return {side: performed(moves, REST, place, sizes, time) for side, moves in score.moves.items()}


def _vary(channels: dict[float, Floats], score: Score, time: Floats, random: np.random.Generator) -> None:
    """Another performance is another: its wrists stray by a centimetre, and its palms by a few degrees."""
    knots = np.linspace(0.0, score.seconds, 2 + round(score.seconds))
    for one in channels.values():
        astray = random.normal(size=(len(knots), 5)) * [0.008, 0.008, 0.008, 0.06, 0.06]
        one[:, :5] += PchipInterpolator(knots, astray)(np.clip(time, 0.0, score.seconds))


def _upper(carriage: Carriage, rhythm: Rhythm, channels: dict[float, Floats]) -> Upper:
    """Arms as channels have them, others as they swing; the chest goes along a little less than in plain walking."""
    arms = {side: swinging_arm(carriage, rhythm, side) for side in (LEFT, RIGHT)}
    for side, one in channels.items():
        palm = {"pronation": one[:, PRONATION], "extension": one[:, EXTENSION]}
        arms[side] = reaching_arm(side, one[:, WRIST], _ELBOW, **palm)
    return trunk(replace(carriage, twist=0.6 * carriage.twist), rhythm), arms


def sample_gestures() -> dict[str, Clip]:
    """Bodies that gesture as they walk, and the hands of each, by name: those of SAMPLE_HANDS."""
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
