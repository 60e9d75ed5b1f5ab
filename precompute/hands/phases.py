"""The phases of a gesture: where a hand speeds up or slows down, which way it moves, and where it holds still.

Majkowska, Zordan and Faloutsos 2006, 4: phases are distinguished by the signs of the first and second derivatives of
the hand's points, which do not depend on the size of the gesture.
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

SMOOTHING = 0.04  # seconds: the standard deviation of the Gaussian that derivatives are taken with
DEAD_ZONE = 0.05  # of a derivative's peak
NOISE_ZONE = 3.0  # standard deviations of the noise that noisy points add to a derivative
RESTING_SPEED, RESTING_ACCELERATION = 0.01, 0.1  # metres per second, and per second squared: less is no gesture
MEDIAN_LENGTH = 1.538  # of vectors whose three components have a standard deviation of 1
SHORTEST_HOLD = 0.08  # seconds

PhaseKind = Literal["stroke", "hold", "preparation", "retraction"]


class Derivatives(NamedTuple):
    """First and second derivatives [F, 4, 3] of a hand's points, and their dead zones.

    velocity: counts as 0 below `still`, both metres per second. acceleration: counts as 0 below `steady`, both metres
    per second squared.
    """

    velocity: Floats
    acceleration: Floats
    still: float
    steady: float


def derivatives(points: Floats, rate: float) -> Derivatives:
    """Returns the derivatives of points [F, 4, 3], metres, at `rate` frames per second; 0 for less than 3 frames."""
    if len(points) < 3:
        nothing = np.zeros(points.shape)
        return Derivatives(nothing, nothing, RESTING_SPEED, RESTING_ACCELERATION)
    width = SMOOTHING * rate
    noise = _noise(points)
    velocity, acceleration = (
        gaussian_filter1d(points, width, axis=0, order=order, mode="nearest") * rate**order for order in (1, 2)
    )
    # the standard deviations of white noise of the points after these filters
    on_velocity = noise * rate / np.sqrt(4.0 * np.sqrt(np.pi) * width**3)
    on_acceleration = noise * rate**2 * np.sqrt(3.0 / (8.0 * np.sqrt(np.pi) * width**5))
    still = max(RESTING_SPEED, DEAD_ZONE * _peak(velocity), NOISE_ZONE * on_velocity)
    steady = max(RESTING_ACCELERATION, DEAD_ZONE * _peak(acceleration), NOISE_ZONE * on_acceleration)
    return Derivatives(velocity, acceleration, still, steady)


def _peak(values: Floats) -> float:
    """Returns the 99th percentile over frames of the longest vector of a frame [F, 4, 3]."""
    return float(np.percentile(np.linalg.norm(values, axis=2).max(axis=1), 99.0))


def _noise(points: Floats) -> float:
    """Returns the standard deviation of white noise on points, metres, from their third differences.

    Motion itself contributes little to third differences.
    """
    thirds = np.linalg.norm(np.diff(points, n=3, axis=0), axis=2)
    return float(np.median(thirds) / MEDIAN_LENGTH / np.sqrt(20.0)) if len(thirds) else 0.0


@dataclass(frozen=True)
class Phase:
    """A phase of a gesture, from frame `begin` up to, but not including, frame `end`."""

    kind: PhaseKind
    begin: int
    end: int


def phases(motion: HandMotion, rate: float) -> list[Phase]:
    """Returns the phases of a hand in order (table 1 of the paper).

    A stretch where the wrist is still is a hold. A stretch between two holds is cut into movements where its speed is
    least. A movement with more force than its neighbours is a stroke. Of the others, a movement away from where the arm
    would hang is a preparation, and a movement back is a retraction.
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
    found_phases = []
    for number, (still, begin, end) in enumerate(spans):
        around = [peaks[other] for other in (number - 1, number + 1) if 0 <= other < len(spans) and peaks[other] > 0.0]
        kind: PhaseKind
        if still:
            kind = "hold"
        elif around and peaks[number] > max(around):
            kind = "stroke"
        else:
            kind = "preparation" if out[end - 1] >= out[begin] else "retraction"
        found_phases.append(Phase(kind, begin, end))
    return found_phases


def _spans(speed: Floats, still: float, shortest: int) -> list[tuple[bool, int, int]]:
    """Returns holds (True) and movements (False), each with its first frame and the frame after its last.

    A stretch of rest of less than `shortest` frames joins the movement before it.
    """
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
    """Returns the frames where one movement ends and another begins.

    There the speed falls below half of the peaks on both sides.
    """
    found: list[int] = []
    for at in np.flatnonzero((speed[1:-1] <= speed[:-2]) & (speed[1:-1] < speed[2:])) + 1:
        since = found[-1] if found else 0
        if at - since >= apart and len(speed) - at >= apart:
            before, after = speed[since:at].max(), speed[at:].max()
            if speed[at] < 0.5 * min(before, after):
                found.append(int(at))
    return found


def count_phases(found: Sequence[Phase]) -> dict[str, int]:
    """Returns the number of phases of each kind."""
    return dict(Counter(phase.kind for phase in found))
