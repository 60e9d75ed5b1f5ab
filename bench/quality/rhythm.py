"""How a motion keeps time: arms against legs, and phases against the knees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles

LEAST_SWING = 0.03  # metres of amplitude: an arm that swings less, as under a box, has no phase to speak of
LEAST_SHARE = 0.3  # of an arm's motion at the stride's own period: with less, as when dribbling, it has another time
TREMBLE = 0.03  # seconds over which the knees' way is smoothed before their passes are counted
CLEAR_PASS = 0.25  # of the knees' usual amplitude, to be exceeded on both sides of a pass


def swing(clip: Clip, roles: Roles, joint: str, about: str | None = None) -> Floats:
    """How far a joint is forward of another, or of the root [F], metres; both are roles' names."""
    positions = joint_positions(clip)
    centre = positions[:, getattr(roles, about) if about else roles.root]
    return np.asarray(np.sum((positions[:, getattr(roles, joint)] - centre) * forward(positions, roles), axis=1))


def arm_lag(clip: Clip, phase: Floats, roles: Roles) -> float:
    """How far the arms' swing is behind the opposite legs', as a part of a stride in (-0.5, 0.5], mean of both sides.

    phase [F] is the clip's, in cycles. Swing is the wrist's (knee's) way forward of the shoulder (root), at the
    stride's own period. NaN if neither arm swings in time with the stride.
    """
    weights = np.gradient(phase)  # so that every part of the stride counts alike, however fast it passes

    def wave(way: Floats) -> tuple[complex, float]:
        way = way - np.average(way, weights=weights)
        found = complex(2.0 * np.average(way * np.exp(-2j * np.pi * phase), weights=weights))
        return found, 0.5 * abs(found) ** 2 / float(np.average(way**2, weights=weights))

    behind = 0j
    for arm, leg in (("left", "right"), ("right", "left")):
        hand, share = wave(swing(clip, roles, f"{arm}_wrist", f"{arm}_shoulder"))
        if abs(hand) > LEAST_SWING and share > LEAST_SHARE:
            behind += hand * np.conj(wave(swing(clip, roles, f"{leg}_knee"))[0])
    return float(-np.angle(behind) / (2.0 * np.pi)) if behind else float("nan")


def lag_error(result: Clip, truth: Clip, phase: Floats, roles: Roles) -> float:
    """Radians of a stride by which the arms are out of step, against the truth; NaN where they do not swing."""
    frames = min(result.frame_count, truth.frame_count)
    lags = [arm_lag(clip.frames(0, frames), phase[:frames], roles) for clip in (result, truth)]
    apart = lags[0] - lags[1]
    return float(2.0 * np.pi * abs(apart - np.round(apart)))


def knee_passes(clip: Clip, roles: Roles) -> NDArray[np.int64]:
    """The frames at which the left knee passes the right one going forward, clearly apart before and after."""
    apart = swing(clip, roles, "left_knee", "right_knee")
    apart = gaussian_filter1d(apart, TREMBLE * clip.rate)
    clear = CLEAR_PASS * np.sqrt(2.0 * np.mean(apart**2))
    decided = np.flatnonzero(np.abs(apart) > clear)
    before, after = decided[:-1], decided[1:]
    passed = (apart[before] < 0.0) & (apart[after] > 0.0)
    return np.array(
        [
            first + int(np.flatnonzero(apart[first : last + 1] < 0.0)[-1])
            for first, last in zip(before[passed], after[passed], strict=True)
        ],
        np.int64,
    )


def concentration(phase: Floats) -> float:
    """How much alike phases [n] in cycles are: the length of the mean of exp(2 pi i phase), 1 if all agree."""
    return abs(resultant(phase)) if len(phase) else float("nan")


def resultant(phase: Floats) -> complex:
    """The mean of exp(2 pi i phase) over phases [n] in cycles: its angle is their mean."""
    return complex(np.mean(np.exp(2j * np.pi * phase)))


def forward(positions: Floats, roles: Roles) -> Floats:
    """Unit vectors over the floor [F, 3] in front of the hips."""
    ahead = np.cross(positions[:, roles.left_hip] - positions[:, roles.right_hip], [0.0, 1.0, 0.0])
    return np.asarray(ahead / np.linalg.norm(ahead, axis=1, keepdims=True))
