"""A gait that turns into another: a blend of all parameters and curves of the two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motionsplice.motion.procedural.gait import Gait
from motionsplice.motion.quaternion import Floats


def _registered(u: Floats, duty: Floats, own: float) -> Floats:
    """Maps phases `u` [n] of a gait with duty `duty` [n] to the phases [n] of a gait with duty `own`.

    The map of the cycle is smooth. It takes heel strike to heel strike and toe-off to toe-off.
    """
    cycle = np.floor(u)
    u = u - cycle
    standing = u < duty
    length, image = np.where(standing, duty, 1.0 - duty), np.where(standing, own, 1.0 - own)
    stance, swing = own / duty, (1.0 - own) / (1.0 - duty)
    slope = 2.0 * stance * swing / (stance + swing) * length
    x = (u - np.where(standing, 0.0, duty)) / length
    bulge = slope * x * (1.0 - x) * (1.0 - 2.0 * x)
    return cycle + np.where(standing, 0.0, own) + image * x * x * (3.0 - 2.0 * x) + bulge


@dataclass(frozen=True)
class Turning:
    """A blend of two gaits: the first at weight 0, the second at weight 1. All weights are [n]."""

    first: Gait
    second: Gait

    def value(self, name: str, weight: Floats) -> Floats:
        """Returns a parameter of the gait by its name [n]."""
        first, second = getattr(self.first, name), getattr(self.second, name)
        return np.asarray(first + (second - first) * weight)

    def foot(self, u: Floats, weight: Floats) -> Floats:
        """Returns the foot's pitch [n] at the foot's phases [n]."""
        return self._mixed([gait.foot(at) for gait, at in self._both(u, weight)], weight)

    def swing(self, u: Floats, weight: Floats) -> Floats:
        """Returns the blend of `Gait.swing`, [n, 2]."""
        return self._mixed([gait.swing(at) for gait, at in self._both(u, weight)], weight[:, None])

    def pelvis_turn(self, phase: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
        """Returns the blend of `Gait.pelvis_turn`: yaw, pitch and roll, each [n]."""
        turns = zip(self.first.pelvis_turn(phase), self.second.pelvis_turn(phase), strict=True)
        yaw, pitch, roll = (self._mixed(both, weight) for both in turns)
        return yaw, pitch, roll

    def height(self, weight: Floats) -> Floats:
        """Returns the blend of `Gait.height`, [n, 5]."""
        return self._mixed((self.first.height, self.second.height), weight[:, None])

    def surge(self, weight: Floats) -> Floats:
        """Returns the blend of `Gait.surge`, [n, 5]."""
        return self._mixed((self.first.surge, self.second.surge), weight[:, None])

    def _both(self, u: Floats, weight: Floats) -> list[tuple[Gait, Floats]]:
        duty = self.value("duty", weight)
        return [(gait, _registered(u, duty, gait.duty)) for gait in (self.first, self.second)]

    @staticmethod
    def _mixed(both: Sequence[Floats], weight: Floats) -> Floats:
        return np.asarray(both[0] + (both[1] - both[0]) * weight)
