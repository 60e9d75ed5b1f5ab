"""Skeletons: the joints of a rig, their hierarchy and their offsets in the bind pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import ClipError, did_you_mean
from motionsplice.motion.quaternion import Floats

Integers = NDArray[np.int64]


def chain(parents: Integers, joint: int) -> list[int]:
    """Returns the joints from `joint` up to its root, both included. A root's entry in `parents` [J] is negative."""
    path = [joint]
    while parents[path[-1]] >= 0:
        path.append(int(parents[path[-1]]))
    return path


def subtree(parents: Integers, joint: int) -> list[int]:
    """Returns `joint` and all its descendants, parent before child, in the order of `parents` [J]."""
    inside = {joint}
    for candidate in range(joint + 1, len(parents)):
        if int(parents[candidate]) in inside:
            inside.add(candidate)
    return sorted(inside)


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A rig of J joints in its bind pose, in which every joint's local frame is aligned with the world.

    Joints are ordered parent before child, below a single root.

    Attributes:
        names: The J joint names, all different.
        parents: [J] the index of each joint's parent. The root is joint 0, and its parent is -1.
        offsets: [J, 3] metres, from the parent to the joint in the parent's frame. The root's offset is ignored.
        end_parents: [E] the joint that carries each end site (the tip of a toe, of a finger, of the head).
        end_offsets: [E, 3] metres, from that joint to the end site, in the joint's frame.

    Raises:
        ClipError: Names repeat, shapes do not match, joints are out of order, an end site's parent does not exist, or
            an offset is not finite.
    """

    names: tuple[str, ...]
    parents: Integers
    offsets: Floats
    end_parents: Integers
    end_offsets: Floats

    def __post_init__(self) -> None:
        count = len(self.names)
        if count == 0:
            raise ClipError("the skeleton has no joints")
        if len(set(self.names)) != count:
            repeated = next(name for i, name in enumerate(self.names) if name in self.names[:i])
            raise ClipError("two joints have the same name", place=f"joint {repeated!r}", mend="Rename one of them")
        if self.parents.shape != (count,) or self.offsets.shape != (count, 3):
            raise ClipError(f"{count} joints need parents [{count}] and offsets [{count}, 3]")
        if self.parents[0] != -1 or np.any(self.parents[1:] < 0) or np.any(self.parents >= np.arange(count)):
            raise ClipError("joints must be ordered parent before child, below a single root")
        if self.end_offsets.shape != (len(self.end_parents), 3):
            raise ClipError("every end site needs one parent and one offset")
        if np.any((self.end_parents < 0) | (self.end_parents >= count)):
            raise ClipError("the parent of an end site does not exist")
        if not (np.isfinite(self.offsets).all() and np.isfinite(self.end_offsets).all()):
            raise ClipError("a bone offset is not a finite number")

    def __eq__(self, other: object) -> bool:
        """Whether both are the same rig, to the last bit."""
        return self is other or (isinstance(other, Skeleton) and self._contents == other._contents)

    def __hash__(self) -> int:
        return hash(self._contents)

    @cached_property
    def _contents(self) -> tuple[tuple[str, ...], bytes, bytes, bytes, bytes]:
        arrays = (self.parents, self.offsets, self.end_parents, self.end_offsets)
        parents, offsets, end_parents, end_offsets = (array.tobytes() for array in arrays)
        return self.names, parents, offsets, end_parents, end_offsets

    @property
    def joint_count(self) -> int:
        """The number of joints, J, without end sites."""
        return len(self.names)

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """For each joint, the indices of its children."""
        return tuple(tuple(np.flatnonzero(self.parents == joint).tolist()) for joint in range(self.joint_count))

    def index(self, name: str) -> int:
        """Returns the index of the joint called `name`.

        Raises:
            ClipError: No joint has that name. The message suggests similar names.
        """
        try:
            return self.names.index(name)
        except ValueError:
            raise ClipError(f"unknown joint {name!r}", mend=did_you_mean(name, self.names)) from None

    def chain(self, joint: int) -> list[int]:
        """Returns the joints from `joint` up to the root, both included."""
        return chain(self.parents, joint)

    def subtree(self, joint: int) -> list[int]:
        """Returns `joint` and all its descendants, parent before child."""
        return subtree(self.parents, joint)

    def bone_length(self, joint: int) -> float:
        """Returns the distance in metres from `joint` to its parent."""
        return float(np.linalg.norm(self.offsets[joint]))

    def scaled(self, factor: float) -> Skeleton:
        """Returns the same rig, `factor` times as large."""
        return Skeleton(self.names, self.parents, self.offsets * factor, self.end_parents, self.end_offsets * factor)


@lru_cache(maxsize=16)
def shared(skeleton: Skeleton) -> Skeleton:
    """Returns the first of equal skeletons, so that what is found of a rig is found once for its clips."""
    return skeleton
