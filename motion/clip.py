"""A clip: the motion of one skeleton, sampled at a fixed rate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from motionsplice.motion import quaternion
from motionsplice.motion.errors import ClipError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton

FARTHEST = 1e6  # metres from the origin
ROUNDING = 1e-14  # error of a unit quaternion's length that is left uncorrected


@dataclass(frozen=True, eq=False)
class Clip:
    """The motion of one skeleton over F frames: right-handed, Y up, in metres and seconds.

    A clip is immutable; its methods return new clips. Rotations are normalised when the clip is made, and their signs
    are chosen so that successive frames lie in one hemisphere.

    Attributes:
        name: The clip's name in messages and banks.
        skeleton: The rig, with J joints.
        rate: Frames per second.
        root_positions: [F, 3] metres, the root's position in the world.
        rotations: [F, J, 4] unit quaternions, xyzw. Each joint's rotation in its parent's frame; the root's in the
            world.

    Raises:
        ClipError: Shapes do not match, a number is not finite, a rotation is not within 1e-3 of unit length, the root
            is farther than 1e6 m from the origin, there are no frames, or the rate is not positive.

    Example:
        ```python
        import numpy as np
        from motionsplice import Clip, Skeleton

        arm = Skeleton(
            names=("shoulder", "elbow"),
            parents=np.array([-1, 0]),
            offsets=np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]]),
            end_parents=np.array([1]),
            end_offsets=np.array([[0.25, 0.0, 0.0]]),
        )
        still = np.tile([0.0, 0.0, 0.0, 1.0], (60, 2, 1))
        clip = Clip("still", arm, rate=30.0, root_positions=np.zeros((60, 3)), rotations=still)
        print(clip.duration, clip.resampled(60.0).frame_count)
        ```
    """

    name: str
    skeleton: Skeleton
    rate: float
    root_positions: Floats
    rotations: Floats

    def __post_init__(self) -> None:
        self._check_all_but_rotations()
        if _is_even(self.rotations):  # nearly all are, and then they need no second look
            return
        lengths, where = quaternion.length(self.rotations), f"clip {self.name!r}"
        if not (unit_length := np.abs(lengths - 1.0) <= 1e-3).all():  # also catches NaN
            if not np.isfinite(self.rotations).all():
                raise self._not_finite("joint rotation", self.rotations)
            frame = int(np.argwhere(~unit_length)[0][0])
            raise ClipError("a rotation is not a unit quaternion", place=f"{where}, frame {frame}")
        # Rotations that need no change are not copied, so that a part of a clip shares its memory, bit for bit.
        rounded = np.abs(lengths - 1.0).max() > ROUNDING
        unit = np.asarray(self.rotations / lengths[..., None]) if rounded else self.rotations
        object.__setattr__(self, "rotations", quaternion.one_hemisphere(unit))

    @classmethod
    def of_valid(cls, name: str, skeleton: Skeleton, rate: float, root_positions: Floats, rotations: Floats) -> Self:
        """Makes a clip whose rotations are those of a clip, or computed from them, so that nobody checks them again.

        They must be as the constructor leaves them: of unit length, successive frames in one hemisphere. This is not
        for numbers from outside. Everything else is checked. Raises ClipError.
        """
        clip = object.__new__(cls)
        given = {"root_positions": root_positions, "rotations": rotations}
        for field, value in {"name": name, "skeleton": skeleton, "rate": rate, **given}.items():
            object.__setattr__(clip, field, value)
        clip._check_all_but_rotations()
        return clip

    def _check_all_but_rotations(self) -> None:
        frames, joints = len(self.root_positions), self.skeleton.joint_count
        where = f"clip {self.name!r}"
        if frames == 0:
            raise ClipError("the clip has no frames", place=where)
        if not (np.isfinite(self.rate) and self.rate > 0.0):
            problem = f"the rate must be positive, but is {self.rate} frames per second"
            raise ClipError(problem, place=where)
        if self.root_positions.shape != (frames, 3) or self.rotations.shape != (frames, joints, 4):
            expected = f"root positions [{frames}, 3] and rotations [{frames}, {joints}, 4]"
            found = f"{list(self.root_positions.shape)} and {list(self.rotations.shape)}"
            raise ClipError(f"expected {expected}, found {found}", place=where)
        if not np.abs(self.root_positions).max() <= FARTHEST:  # also catches NaN
            if not np.isfinite(self.root_positions).all():
                raise self._not_finite("root position", self.root_positions)
            raise ClipError(
                f"the root is farther than {FARTHEST:g} m from the origin", place=where, mend="Check the unit of length"
            )

    def _not_finite(self, label: str, values: Floats) -> ClipError:
        frame = int(np.argwhere(~np.isfinite(values))[0][0])
        return ClipError(f"a {label} is not a finite number", place=f"clip {self.name!r}, frame {frame}")

    @property
    def frame_count(self) -> int:
        """The number of frames, F."""
        return len(self.root_positions)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last: (F - 1) / rate."""
        return (self.frame_count - 1) / self.rate

    def frames(self, first: int, stop: int) -> Clip:
        """Returns the frames from `first` up to, but not including, `stop` as a clip that shares memory with this one.

        Raises:
            ClipError: The range is empty.
        """
        chosen = slice(first, stop)
        return Clip.of_valid(self.name, self.skeleton, self.rate, self.root_positions[chosen], self.rotations[chosen])

    def followed_by(self, root_positions: Floats, rotations: Floats) -> Clip:
        """Returns the clip with more frames after its own: root positions [n, 3] and rotations [n, J, 4].

        Raises:
            ClipError: The new frames are invalid, as in the constructor.
        """
        roots = np.concatenate([self.root_positions, root_positions])
        after = replace(
            self,
            root_positions=roots[-1 - len(rotations) :],
            rotations=np.concatenate([self.rotations[-1:], rotations]),
        )
        all_rotations = np.concatenate([self.rotations, after.rotations[1:]])
        return Clip.of_valid(self.name, self.skeleton, self.rate, roots, all_rotations)

    def sampled(self, frames: ArrayLike) -> tuple[Floats, Floats]:
        """Interpolates the clip: positions linearly, rotations by slerp.

        Args:
            frames: [n] real-valued frame numbers; values outside the clip give its first or last frame.

        Returns:
            Root positions [n, 3] in metres and rotations [n, J, 4].
        """
        before, after, t = quaternion.neighbours(self.frame_count, frames)
        positions = self.root_positions[before] + t[:, None] * (
            self.root_positions[after] - self.root_positions[before]
        )
        return positions, quaternion.slerp(self.rotations[before], self.rotations[after], t[:, None])

    def resampled(self, rate: float) -> Clip:
        """Returns the same motion at `rate` frames per second. The last sample is at or before the clip's end."""
        if rate == self.rate:
            return self
        count = int(np.floor(self.duration * rate + 1e-9)) + 1
        positions, rotations = self.sampled(np.arange(count) * (self.rate / rate))
        return Clip.of_valid(self.name, self.skeleton, rate, positions, quaternion.one_hemisphere(rotations))


def _is_even(rotations: Floats) -> bool:
    """Returns whether rotations [F, J, 4] are certainly as a clip has them."""
    if rotations.dtype != np.float64 or not rotations.flags.c_contiguous:
        return False
    from motionsplice.motion.evenness import unevenness  # Numba takes half a second, and `inspect` needs none

    error, least = unevenness(rotations)
    return error < 0.5 * ROUNDING and least > ROUNDING
