"""Measures of a motion's timing: the arms relative to the legs, and phases relative to the knees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles

LEAST_SWING = 0.03  # metres of amplitude: an arm that swings less, as when carrying a box, has no meaningful phase
LEAST_SHARE = (
    0.3  # least share of an arm's motion at the stride's period; with less, as when dribbling, the legs do not time it
)
TREMBLE = 0.03  # seconds of smoothing of the knees' motion before passes are counted
CLEAR_PASS = 0.25  # part of the knees' usual amplitude that they must exceed before and after a pass


def swing(clip: Clip, roles: Roles, joint: str, about: str | None = None) -> Floats:
    """Returns how far a joint is in front of another joint, or of the root [F], in metres. Both are names of roles."""
    positions = joint_positions(clip)
    centre = positions[:, getattr(roles, about) if about else roles.root]
    return np.asarray(np.sum((positions[:, getattr(roles, joint)] - centre) * forward(positions, roles), axis=1))


def arm_lag(clip: Clip, phase: Floats, roles: Roles) -> float:
    """Returns how far the arms swing behind the opposite legs, in strides in (-0.5, 0.5], the mean of both sides.

    phase [F]: the clip's phase in cycles. Swing is the forward position of a wrist relative to its shoulder, or of a
    knee relative to the root, at the stride's period. NaN if neither arm swings in time with the stride.
    """
    weights = np.gradient(phase)  # all parts of the stride count equally, however long they take

    def wave(distance: Floats) -> tuple[complex, float]:
        """Returns the amplitude at the stride's period, and its share of the motion's power."""
        distance = distance - np.average(distance, weights=weights)
        amplitude = complex(2.0 * np.average(distance * np.exp(-2j * np.pi * phase), weights=weights))
        return amplitude, 0.5 * abs(amplitude) ** 2 / float(np.average(distance**2, weights=weights))

    behind = 0j
    for arm, leg in (("left", "right"), ("right", "left")):
        hand, share = wave(swing(clip, roles, f"{arm}_wrist", f"{arm}_shoulder"))
        if abs(hand) > LEAST_SWING and share > LEAST_SHARE:
            behind += hand * np.conj(wave(swing(clip, roles, f"{leg}_knee"))[0])
    return float(-np.angle(behind) / (2.0 * np.pi)) if behind else float("nan")


def lag_error(result: Clip, truth: Clip, phase: Floats, roles: Roles) -> float:
    """Returns the difference of the arms' lag between result and truth, in radians of a stride; NaN without swing."""
    frames = min(result.frame_count, truth.frame_count)
    lags = [arm_lag(clip.frames(0, frames), phase[:frames], roles) for clip in (result, truth)]
    apart = lags[0] - lags[1]
    return float(2.0 * np.pi * abs(apart - np.round(apart)))


def knee_passes(clip: Clip, roles: Roles) -> NDArray[np.int64]:
    """Returns the frames at which the left knee passes the right one going forward, clearly apart before and after."""
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
    """Returns how similar phases [n] in cycles are: the length of the mean of exp(2 pi i phase), 1 if all are equal."""
    return abs(resultant(phase)) if len(phase) else float("nan")


def resultant(phase: Floats) -> complex:
    """Returns the mean of exp(2 pi i phase) over phases [n] in cycles. Its angle is their mean phase."""
    return complex(np.mean(np.exp(2j * np.pi * phase)))


def forward(positions: Floats, roles: Roles) -> Floats:
    """Returns horizontal unit vectors [F, 3] that point forward from the hips."""
    ahead = np.cross(positions[:, roles.left_hip] - positions[:, roles.right_hip], [0.0, 1.0, 0.0])
    return np.asarray(ahead / np.linalg.norm(ahead, axis=1, keepdims=True))
