"""Torso offsets: what an action's torso does beyond its gait, frame by frame. Posture `relative` carries this over.

The papers keep an action's mean posture (Heck et al. 2006, 3.3) but lose all other deliberate motion of the shoulders;
their section 5 names this limitation. The *neutral* is the same gait captured without the action. It shows what the
gait alone does at each phase of the stride; the rest is the action's own (docs/method.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.alignment.harmonics import fitted, waves
from motionsplice.precompute.body.best_rotations import best_rotations

HARMONICS = 4  # of the stride: what a gait repeats; more would fit the noise of a single take
SMOOTHING = 0.1  # seconds: jitter of the phases is faster than shoulders move
STEADYING = 1e-5  # keeps coefficients that less than a stride does not determine at zero


@dataclass(frozen=True, eq=False)
class MeanStride:
    """The mean torso cloud of a gait by phase: coefficients [1 + 2 HARMONICS, P, 3] of its Fourier series, metres."""

    coefficients: Floats

    @classmethod
    def of(cls, clouds: Floats, phase: Floats) -> MeanStride:
        """Fits the series to torso clouds [F, P, 3] in the posture frame, metres, at `phase` [F] in cycles.

        Every part of the stride has the same weight, however fast the clip passes it.
        """
        pace = np.gradient(phase)
        weights = np.sqrt(pace / np.mean(pace))
        found = fitted(clouds.reshape(len(clouds), -1), waves(phase, HARMONICS), STEADYING, weights)
        return cls(found.reshape(-1, *clouds.shape[1:]))

    def at(self, phase: Floats) -> Floats:
        """Returns the mean clouds [F, P, 3] at `phase` [F], metres."""
        return np.tensordot(waves(phase, HARMONICS), self.coefficients, axes=1)


def torso_offsets(clouds: Floats, phase: Floats, rate: float, neutral: MeanStride, period: int = 0) -> Floats:
    """Returns the rotations [F, 4], in the posture frame, from the neutral's torso at the same phase to the clip's own.

    clouds: [F, P, 3] the clip's torso clouds in the posture frame, metres. phase: [F] cycles, aligned to the same
    baseline as the neutral. rate: frames per second. period: frames of a whole cycle, which the clouds repeat;
    0 for other clips. Successive rotations lie in one hemisphere.
    """
    turns = quaternion.one_hemisphere(best_rotations(clouds, neutral.at(phase)))
    if period:
        turns = gaussian_filter1d(turns[:period], SMOOTHING * rate, axis=0, mode="wrap")[np.arange(len(turns)) % period]
    else:
        turns = gaussian_filter1d(turns, SMOOTHING * rate, axis=0, mode="nearest")
    return quaternion.normalise(turns)


def shoulder_motion(offsets: Floats) -> float:
    """Returns the root-mean-square angle, in radians, of torso offsets [F, 4] from their mean.

    An action loses this motion of its shoulders unless its posture is `relative`.
    """
    return float(np.sqrt(np.mean(quaternion.angle(offsets, _mean(offsets)) ** 2)))


def believed(offsets: Floats, count: int, noise: float) -> Floats:
    """Returns torso offsets [rows, 4] whose motion about their mean is scaled by a Wiener filter's gain.

    Part of that motion is not deliberate: no two strides are alike. The neutral shows how much, because nothing that it
    does beyond its own mean stride is deliberate. The gain is 1 - noise^2 / s^2, at least 0, with s the
    `shoulder_motion` of the first `count` offsets, and `noise` that of the neutral, radians.
    """
    motion = shoulder_motion(offsets[:count])
    gain = 0.0 if motion <= noise else 1.0 - (noise / motion) ** 2
    centre = np.broadcast_to(_mean(offsets[:count]), offsets.shape)
    return quaternion.one_hemisphere(quaternion.slerp(centre, offsets, np.full(len(offsets), gain)))


def _mean(offsets: Floats) -> Floats:
    """Returns the mean rotation [4] of offsets [F, 4], w >= 0."""
    mean: Floats = np.linalg.eigh(offsets.T @ offsets)[1][:, -1]
    return -mean if mean[3] < 0.0 else mean
