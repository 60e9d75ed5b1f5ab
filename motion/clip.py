"""A clip: one skeleton's motion, sampled at a fixed rate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from motionsplice.motion import quaternion
from motionsplice.motion.errors import ClipError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton

FARTHEST = 1e6  # metres
ROUNDING = 1e-14  # of a unit quaternion's length


@dataclass(frozen=True, eq=False)
class Clip:
    """A motion: right-handed, Y up, metres, seconds.

    rate:           frames per second.
    root_positions: [F, 3] the root in the world.
    rotations:      [F, J, 4] xyzw, each joint's rotation in its parent's frame (the root's: in the world),
                    unit length, successive frames in one hemisphere.

    Raises ClipError on wrong shapes, non-finite or absurd numbers, no frame at all, or a rate that is not positive.
    """

    name: str
    skeleton: Skeleton
    rate: float
    root_positions: Floats
    rotations: Floats

    def __post_init__(self) -> None:
        frames, joints = len(self.root_positions), self.skeleton.joint_count
        where = f"clip {self.name!r}"
        if frames == 0:
            raise ClipError("it has no frames", place=where)
        if not (np.isfinite(self.rate) and self.rate > 0.0):
            raise ClipError(f"its rate is {self.rate} frames per second", place=where)
        if self.root_positions.shape != (frames, 3) or self.rotations.shape != (frames, joints, 4):
            raise ClipError(f"{frames} frames of {joints} joints need rotations [{frames}, {joints}, 4]", place=where)
        if not np.isfinite(self.root_positions).all():
            raise self._not_finite("root position", self.root_positions)
        lengths = quaternion.length(self.rotations)
        if not (sound := np.abs(lengths - 1.0) <= 1e-3).all():  # NaN is not
            if not np.isfinite(self.rotations).all():
                raise self._not_finite("joint rotation", self.rotations)
            frame = int(np.argwhere(~sound)[0][0])
            raise ClipError("a rotation is not a unit quaternion", place=f"{where}, frame {frame}")
        if np.abs(self.root_positions).max() > FARTHEST:
            raise ClipError(
                f"its root is farther than {FARTHEST:g} m from the origin", place=where, mend="Is the unit right?"
            )
        # Left as they are if they are sound, so that a part of a clip shares its memory and keeps its very bits.
        rounded = np.abs(lengths - 1.0).max() > ROUNDING
        unit = np.asarray(self.rotations / lengths[..., None]) if rounded else self.rotations
        object.__setattr__(self, "rotations", quaternion.one_hemisphere(unit))

    def _not_finite(self, label: str, values: Floats) -> ClipError:
        frame = int(np.argwhere(~np.isfinite(values))[0][0])
        return ClipError(f"a {label} is not a finite number", place=f"clip {self.name!r}, frame {frame}")

    @property
    def frame_count(self) -> int:
        return len(self.root_positions)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.frame_count - 1) / self.rate

    def frames(self, first: int, stop: int) -> Clip:
        """Frames `first` to `stop` (exclusive) as a clip."""
        return replace(self, root_positions=self.root_positions[first:stop], rotations=self.rotations[first:stop])

    def sampled(self, frames: ArrayLike) -> tuple[Floats, Floats]:
        """Root positions [n, 3] and rotations [n, J, 4] at real-valued frames [n], held at both ends."""
        before, after, t = quaternion.neighbours(self.frame_count, frames)
        positions = self.root_positions[before] + t[:, None] * (
            self.root_positions[after] - self.root_positions[before]
        )
        return positions, quaternion.slerp(self.rotations[before], self.rotations[after], t[:, None])

    def resampled(self, rate: float) -> Clip:
        """The same motion at another rate; the last partial frame is dropped."""
        if rate == self.rate:
            return self
        count = int(np.floor(self.duration * rate + 1e-9)) + 1
        positions, rotations = self.sampled(np.arange(count) * (self.rate / rate))
        return replace(self, rate=rate, root_positions=positions, rotations=rotations)
