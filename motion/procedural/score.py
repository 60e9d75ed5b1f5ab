"""Scores of gestures, which bodies and hands perform at their own tempo and size: holds and minimum-jerk moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from motionsplice.motion.procedural.body import LEFT, RIGHT
from motionsplice.motion.procedural.hand_rig import COUNTED, FIST, OPEN, POINT, POSE, RELAXED, THUMBS_UP
from motionsplice.motion.quaternion import Floats

Kind = Literal["count", "point", "wave", "open_close", "thumbs_up"]
PhaseKind = Literal["preparation", "stroke", "hold", "retraction"]
KINDS: tuple[Kind, ...] = ("count", "point", "wave", "open_close", "thumbs_up")
STILL = 0.3  # seconds at rest before the first gesture and after the last
# Channels of a hand: the wrist, metres outward, up and forward of the shoulder; pronation and extension; a finger pose.
WRIST, PRONATION, EXTENSION, FINGERS, CHANNELS = slice(0, 3), 3, 4, slice(5, 5 + POSE), 5 + POSE
REST = np.array([0.02, -0.40, 0.22, 0.35, 0.0, *RELAXED])


@dataclass(frozen=True, eq=False)
class Move:
    """A move to the channels `to` [CHANNELS], from `begin` within `lasting`, both in seconds of the score.

    gesture: the number of its gesture, by which performers scale it; -1 for a return to rest.
    """

    kind: PhaseKind
    begin: float
    lasting: float
    to: Floats
    gesture: int


@dataclass(frozen=True, eq=False)
class Score:
    """The moves of each side's hand, in order, over `seconds`, and the kinds of all gestures."""

    seconds: float
    moves: dict[float, list[Move]]
    kinds: list[Kind]


def least_jerk(t: Floats) -> Floats:
    """Rises from 0 to 1 with t by the minimum-jerk curve of hand movements (Flash and Hogan 1985)."""
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t**3 * (10.0 - 15.0 * t + 6.0 * t * t))


class Writer:
    """Writes the moves of one hand in order. Durations are drawn from ranges in seconds and scaled by `hurry`."""

    def __init__(self, random: np.random.Generator, hurry: float) -> None:
        self.random, self.hurry = random, hurry
        self.time, self.at, self.moves = STILL, REST.copy(), list[Move]()

    def move(self, kind: PhaseKind, lasting: tuple[float, float], to: Floats, gesture: int) -> None:
        seconds = self.random.uniform(*lasting) * self.hurry
        self.moves.append(Move(kind, self.time, seconds, to, gesture))
        self.time, self.at = self.time + seconds, to

    def hold(self, lasting: tuple[float, float]) -> None:
        self.time += self.random.uniform(*lasting) * self.hurry


def write_score(random: np.random.Generator, kinds: list[Kind], sides: tuple[float, ...]) -> Score:
    """Writes a score of gestures of these kinds in order, by the hands in turn."""
    hurry = min(1.0, 9.0 * len(sides) / max(len(kinds), 1)) ** 0.7
    writers = {side: Writer(random, hurry) for side in sides}
    counted = dict.fromkeys(sides, 0)
    for number, kind in enumerate(kinds):
        side = sides[number % len(sides)]
        writer = writers[side]
        counted[side] = counted[side] % 5 + 1 if kind == "count" else 0
        _gesture(writer, kind, number, counted[side])
        last = number + len(sides) >= len(kinds)
        if last or random.random() < 0.45:
            writer.move("retraction", (0.4, 0.65), REST.copy(), -1)
            writer.hold((0.05, 0.35))
    end = max(writer.time for writer in writers.values()) + STILL
    return Score(end, {side: writer.moves for side, writer in writers.items()}, kinds)


def _gesture(writer: Writer, kind: Kind, number: int, counted: int) -> None:
    draw = writer.random

    def place(x: float, y: float, z: float, pronation: float, extension: float, fingers: Floats) -> Floats:
        spot = np.array([x, y, z]) + draw.uniform(-0.06, 0.06, 3)
        palm = np.array([pronation, extension]) + draw.uniform(-0.15, 0.15, 2)
        return np.concatenate([spot, palm, fingers])

    def shifted(to: Floats, **by: tuple[float, float]) -> Floats:
        channels = {"out": 0, "up": 1, "ahead": 2, "pronated": PRONATION, "extended": EXTENSION}
        moved = to.copy()
        for name, span in by.items():
            moved[channels[name]] += draw.uniform(*span)
        return moved

    if kind == "count":
        raised = place(-0.04, 0.02, 0.34, -0.35, 0.1, COUNTED[max(counted, 1)])
        writer.move("preparation", (0.35, 0.55), raised, number)
        writer.move("stroke", (0.12, 0.2), shifted(raised, up=(-0.07, -0.03), extended=(-0.4, -0.2)), number)
        writer.hold((0.15, 0.6))
    elif kind == "point":
        drawn_in = place(0.02, -0.04, 0.24, 1.0, 0.3, POINT)
        writer.move("preparation", (0.35, 0.5), drawn_in, number)
        far = shifted(drawn_in, ahead=(0.14, 0.24), out=(-0.15, 0.2), up=(0.0, 0.16), extended=(-0.4, -0.2))
        writer.move("stroke", (0.2, 0.32), far, number)
        writer.hold((0.25, 0.7))
    elif kind == "wave":
        up = place(0.2, 0.2, 0.26, 1.35, 0.0, OPEN)
        writer.move("preparation", (0.45, 0.65), up, number)
        for stroke in range(int(draw.integers(2, 4))):
            aside = (0.08, 0.13) if stroke % 2 == 0 else (-0.13, -0.08)
            writer.move("stroke", (0.18, 0.26), shifted(writer.at, out=aside, pronated=aside), number)
        writer.hold((0.05, 0.2))
    elif kind == "open_close":
        front = place(-0.02, -0.12, 0.36, 0.2, 0.25, FIST)
        writer.move("preparation", (0.35, 0.5), front, number)
        for shape in (OPEN, FIST)[: int(draw.integers(1, 3))]:
            beat = shifted(writer.at, ahead=(0.03, 0.07) if shape is OPEN else (-0.07, -0.03), extended=(-0.2, 0.2))
            beat[FINGERS] = shape
            writer.move("stroke", (0.18, 0.28), beat, number)
            writer.hold((0.06, 0.3))
    else:
        front = place(-0.06, -0.12, 0.36, -0.05, 0.0, THUMBS_UP)
        writer.move("preparation", (0.35, 0.55), front, number)
        writer.move("stroke", (0.14, 0.22), shifted(front, up=(0.04, 0.09), ahead=(0.0, 0.04)), number)
        writer.hold((0.3, 0.7))


def performed(moves: list[Move], rest: Floats, place: Floats, sizes: Floats, s: Floats) -> Floats:
    """Returns a hand's channels [n, CHANNELS] at times `s` [n] of a score.

    rest:  [CHANNELS] the rest position in the score.
    place: [3] the wrist's rest position in this performance.
    sizes: by gesture, the factor by which the wrist's displacement from rest is scaled.
    """
    here = np.concatenate([place, rest[3:]])
    done = np.tile(here, (len(s), 1))
    for move in moves:
        scale = sizes[move.gesture] if move.gesture >= 0 else 1.0
        to = np.concatenate([place + scale * (move.to[WRIST] - rest[WRIST]), move.to[3:]])
        done += np.multiply.outer(least_jerk((s - move.begin) / move.lasting), to - here)
        here = to
    return done


def phase_spans(moves: list[Move], seconds: float) -> list[tuple[PhaseKind, float, float]]:
    """Returns the phases of one hand in order, each with its begin and end in the score; holds fill the gaps."""
    spans: list[tuple[PhaseKind, float, float]] = []
    time = 0.0
    for move in moves:
        if move.begin > time + 1e-9:
            spans.append(("hold", time, move.begin))
        spans.append((move.kind, move.begin, move.begin + move.lasting))
        time = move.begin + move.lasting
    return [*spans, ("hold", time, seconds)]


SIDES = {"left": (LEFT,), "right": (RIGHT,), "both": (LEFT, RIGHT)}
