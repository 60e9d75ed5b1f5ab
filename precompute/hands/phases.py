"""The phases of a gesture: where a hand speeds up and slows down, which way it goes, and where it holds still.

Majkowska, Zordan and Faloutsos 2006, 4: phases are told apart by the signs of the first and second derivatives of the
points of a hand, which do not depend on how large a gesture is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.hands.points import HAND, LITTLE_SIDE, THUMB_SIDE, HandMotion

SMOOTHING = 0.04  # seconds: the standard deviation of the bell that derivatives are taken with
DEAD_ZONE = 0.05  # of a derivative's peak
NOISE_ZONE = 3.0  # standard deviations of what the noise of points makes of it
RESTING_SPEED, RESTING_ACCELERATION = 0.01, 0.1  # metres per second, and per second squared: no less is a gesture
MEDIAN_LENGTH = 1.538  # of vectors whose three components have a standard deviation of 1
SHORTEST_HOLD = 0.08  # seconds

PhaseKind = Literal["stroke", "hold", "preparation", "retraction"]


class Derivatives(NamedTuple):
    """First and second derivatives [F, 4, 3] of a hand's points, and the dead zone in which each counts as 0."""

    velocity: Floats
    acceleration: Floats
    still: float
    steady: float


def derivatives(points: Floats, rate: float) -> Derivatives:
    """Of points [F, 4, 3] at `rate` frames per second; all 0 where there are too few frames to tell."""
    if len(points) < 3:
        nothing = np.zeros(points.shape)
        return Derivatives(nothing, nothing, RESTING_SPEED, RESTING_ACCELERATION)
    width = SMOOTHING * rate
    noise = _noise(points)
    velocity, acceleration = (
        gaussian_filter1d(points, width, axis=0, order=order, mode="nearest") * rate**order for order in (1, 2)
    )
    # what white noise of the points is after such a filter
    on_velocity = noise * rate / np.sqrt(4.0 * np.sqrt(np.pi) * width**3)
    on_acceleration = noise * rate**2 * np.sqrt(3.0 / (8.0 * np.sqrt(np.pi) * width**5))
    still = max(RESTING_SPEED, DEAD_ZONE * _peak(velocity), NOISE_ZONE * on_velocity)
    steady = max(RESTING_ACCELERATION, DEAD_ZONE * _peak(acceleration), NOISE_ZONE * on_acceleration)
    return Derivatives(velocity, acceleration, still, steady)


def _peak(values: Floats) -> float:
    """The largest of any point [F, 4, 3], but for the hundredth part of frames."""
    return float(np.percentile(np.linalg.norm(values, axis=2).max(axis=1), 99.0))


def _noise(points: Floats) -> float:
    """The standard deviation of white noise on points, metres, from their third differences: motion has hardly any."""
    thirds = np.linalg.norm(np.diff(points, n=3, axis=0), axis=2)
    return float(np.median(thirds) / MEDIAN_LENGTH / np.sqrt(20.0)) if len(thirds) else 0.0


@dataclass(frozen=True)
class Phase:
    """A phase of a gesture, from its first frame to before `end`."""

    kind: PhaseKind
    begin: int
    end: int


def phases(motion: HandMotion, rate: float) -> list[Phase]:
    """The phases of a hand in order (table 1 of the paper).

    Where the wrist is still is a hold. What lies between two holds is parted where its speed is least. Of these
    movements a stroke is one with more force than its neighbours have; of the others, those that lead away from where
    the arm would hang are preparations, and those that lead back retractions.
    """
    wrist = motion.points[:, [THUMB_SIDE, LITTLE_SIDE, HAND]].mean(axis=1)
    if len(wrist) < 3:
        return [Phase("hold", 0, len(wrist))]
    found = derivatives(motion.points, rate)
    chosen = [THUMB_SIDE, LITTLE_SIDE, HAND]
    speed = np.linalg.norm(found.velocity[:, chosen].mean(axis=1), axis=1)
    force = np.linalg.norm(found.acceleration[:, chosen].mean(axis=1), axis=1)
    hanging = [0.0, -float(np.linalg.norm(wrist, axis=1).max()), 0.0]
    out = np.linalg.norm(gaussian_filter1d(wrist, SMOOTHING * rate, axis=0, mode="nearest") - hanging, axis=1)
    spans = _spans(speed, found.still, max(2, round(SHORTEST_HOLD * rate)))
    peaks = [0.0 if still else float(force[begin:end].max()) for still, begin, end in spans]
    told = []
    for number, (still, begin, end) in enumerate(spans):
        around = [peaks[other] for other in (number - 1, number + 1) if 0 <= other < len(spans) and peaks[other] > 0.0]
        kind: PhaseKind
        if still:
            kind = "hold"
        elif around and peaks[number] > max(around):
            kind = "stroke"
        else:
            kind = "preparation" if out[end - 1] >= out[begin] else "retraction"
        told.append(Phase(kind, begin, end))
    return told


def _spans(speed: Floats, still: float, shortest: int) -> list[tuple[bool, int, int]]:
    """Holds (True) and movements, from frame to frame; shorter holds are where one movement gives way to another."""
    moving = speed > still
    cuts = np.flatnonzero(np.diff(moving)) + 1
    spans: list[tuple[bool, int, int]] = []
    for begin, end in zip([0, *cuts], [*cuts, len(speed)], strict=True):
        if not moving[begin] and end - begin >= shortest:
            spans.append((True, int(begin), int(end)))
        elif spans and not spans[-1][0]:
            spans[-1] = (False, spans[-1][1], int(end))
        else:
            spans.append((False, int(begin), int(end)))
    parted = []
    for resting, begin, end in spans:
        within = speed[begin:end]
        lowest = [] if resting else _valleys(within, shortest)
        parted += [(resting, begin + a, begin + b) for a, b in zip([0, *lowest], [*lowest, end - begin], strict=True)]
    return parted


def _valleys(speed: Floats, apart: int) -> list[int]:
    """Where a movement gives way to another: its speed falls to less than half of the peaks on both sides."""
    found: list[int] = []
    for at in np.flatnonzero((speed[1:-1] <= speed[:-2]) & (speed[1:-1] < speed[2:])) + 1:
        since = found[-1] if found else 0
        if at - since >= apart and len(speed) - at >= apart:
            before, after = speed[since:at].max(), speed[at:].max()
            if speed[at] < 0.5 * min(before, after):
                found.append(int(at))
    return found


def count_phases(told: Sequence[Phase]) -> dict[str, int]:
    """How many there are of each kind."""
    return dict(Counter(phase.kind for phase in told))
