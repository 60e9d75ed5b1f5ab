"""Animation samplers at any time (glTF 2.0, 3.11 and appendix C), and the rate at which they were keyed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError
from motionsplice.motion.formats.gltf.container import EXPORT
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.rates import common_rate
from motionsplice.motion.skeleton import Integers

USUAL_RATE = 30.0  # frames per second of animations with a few keys only
FEW_KEYS = 4
SLOWEST, FASTEST = 5.0, 1000.0  # frames per second that keys are taken for a capture's own
UNEVEN = 0.1  # relative: steps between keys that differ more are not those of a capture
ROUNDING = 2.0**-23  # of float32, relative


@dataclass(frozen=True, eq=False)
class Track:
    """A sampler: values [K, width], or [3 K, width] of a cubic spline, at strictly increasing times [K], seconds."""

    times: Floats
    values: Floats
    interpolation: str
    is_rotation: bool

    def __post_init__(self) -> None:
        rows = len(self.times) * (3 if self.interpolation == "CUBICSPLINE" else 1)
        if self.interpolation not in ("LINEAR", "STEP", "CUBICSPLINE"):
            raise FormatError(f"unknown interpolation {self.interpolation!r:.40}", mend=EXPORT)
        if len(self.values) != rows:
            problem = f"an animation has {len(self.values)} values at {len(self.times)} times, expected {rows}"
            raise FormatError(problem, mend=EXPORT)
        if (self.times[1:] <= self.times[:-1]).any():
            raise FormatError("the times of an animation's keys do not increase", mend=EXPORT)

    def sampled(self, times: Floats) -> Floats:
        """Returns the values [n, width] at `times` [n]; before the first key and after the last these keys' own."""
        if self._keyed_at(times):
            keys = self.values.reshape(len(times), -1, self.values.shape[1])  # of a cubic spline with its tangents
            found = keys[:, keys.shape[1] // 2]
            return _unit(found) if self.is_rotation else found
        last = len(self.times) - 1
        before = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, max(last - 1, 0))
        after = np.minimum(before + 1, last)
        step = np.where(after > before, self.times[after] - self.times[before], 1.0)
        t = np.clip((times - self.times[before]) / step, 0.0, 1.0)
        if self.interpolation == "STEP":
            found = self.values[np.where(t >= 1.0, after, before)]
        elif self.interpolation == "CUBICSPLINE":
            found = self._cubic(before, after, step, t)
        elif self.is_rotation:
            return quaternion.slerp(_unit(self.values[before]), _unit(self.values[after]), t)
        else:
            found = self.values[before] + t[:, None] * (self.values[after] - self.values[before])
        return _unit(found) if self.is_rotation else found

    def _keyed_at(self, times: Floats) -> bool:
        """Whether these are the keys' own times, which the file has rounded."""
        if len(times) != len(self.times):
            return False
        return bool(np.abs(times - self.times).max() <= ROUNDING * np.abs(times).max())

    def _cubic(self, before: Integers, after: Integers, step: Floats, t: Floats) -> Floats:
        keys = self.values.reshape(len(self.times), 3, -1)
        t, step = t[:, None], step[:, None]
        begin, leave = keys[before, 1], step * keys[before, 2]
        end, arrive = keys[after, 1], step * keys[after, 0]
        t2, t3 = t * t, t * t * t
        return np.asarray(
            (2.0 * t3 - 3.0 * t2 + 1.0) * begin
            + (t3 - 2.0 * t2 + t) * leave
            + (3.0 * t2 - 2.0 * t3) * end
            + (t3 - t2) * arrive
        )


def key_rate(tracks: list[Track]) -> float:
    """Returns the frames per second of the track with the most keys, or USUAL_RATE if its keys are few or far apart."""
    times = max((track.times for track in tracks), key=len)
    if len(times) < FEW_KEYS:
        return USUAL_RATE
    steps = np.diff(times)
    usual = np.abs(steps / np.median(steps) - 1.0) < UNEVEN
    rate = common_rate(1.0 / float(np.mean(steps[usual])))  # after minutes, float32 rounds single steps too much
    return rate if SLOWEST <= rate <= FASTEST else USUAL_RATE


def _unit(q: Floats) -> Floats:
    length = quaternion.length(q)[..., None]
    if length.all():
        return q / length
    return np.where(length > 0.0, q / np.where(length > 0.0, length, 1.0), quaternion.IDENTITY)
