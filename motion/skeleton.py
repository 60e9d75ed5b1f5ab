"""A rig at rest: joints, their order, and where each sits on its parent."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import ClipError, did_you_mean
from motionsplice.motion.quaternion import Floats

Integers = NDArray[np.int64]


def chain(parents: Integers, joint: int) -> list[int]:
    """The joints from `joint` up to where nothing is above, both included; parents [J] are negative there."""
    up = [joint]
    while parents[up[-1]] >= 0:
        up.append(int(parents[up[-1]]))
    return up


def subtree(parents: Integers, joint: int) -> list[int]:
    """`joint` and everything that hangs on it, parent before child, as `parents` [J] are."""
    inside = {joint}
    for candidate in range(joint + 1, len(parents)):
        if int(parents[candidate]) in inside:
            inside.add(candidate)
    return sorted(inside)


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints ordered parent before child; all local frames are aligned with the world in the bind pose.

    names:       J joint names, each once.
    parents:     [J] index of each joint's parent; the root is joint 0 and its parent is -1.
    offsets:     [J, 3] metres, from the parent to the joint in the parent's frame; the root's is ignored.
    end_parents: [E] joints that carry an end site (the tip of a toe, a finger, the head).
    end_offsets: [E, 3] metres, from that joint to the end site.

    Raises ClipError if any of this does not hold.
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
            twice = next(name for i, name in enumerate(self.names) if name in self.names[:i])
            raise ClipError("two joints have one name", place=f"joint {twice!r}", mend="Rename one of them")
        if self.parents.shape != (count,) or self.offsets.shape != (count, 3):
            raise ClipError(f"{count} joints need parents [{count}] and offsets [{count}, 3]")
        if self.parents[0] != -1 or np.any(self.parents[1:] < 0) or np.any(self.parents >= np.arange(count)):
            raise ClipError("joints must be ordered parent before child, below a single root")
        if self.end_offsets.shape != (len(self.end_parents), 3):
            raise ClipError("every end site needs one parent and one offset")
        if np.any((self.end_parents < 0) | (self.end_parents >= count)):
            raise ClipError("an end site hangs on a joint that is not there")
        if not (np.isfinite(self.offsets).all() and np.isfinite(self.end_offsets).all()):
            raise ClipError("a bone offset is not a finite number")

    @property
    def joint_count(self) -> int:
        return len(self.names)

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """For each joint, the joints that hang on it."""
        return tuple(tuple(np.flatnonzero(self.parents == joint).tolist()) for joint in range(self.joint_count))

    def index(self, name: str) -> int:
        """The index of the joint called `name`; raises ClipError, with the near names, if there is none."""
        try:
            return self.names.index(name)
        except ValueError:
            raise ClipError(f"there is no joint {name!r}", mend=did_you_mean(name, self.names)) from None

    def chain(self, joint: int) -> list[int]:
        """The joints from `joint` up to the root, both included."""
        return chain(self.parents, joint)

    def subtree(self, joint: int) -> list[int]:
        """`joint` and everything that hangs on it, parent before child."""
        return subtree(self.parents, joint)

    def bone_length(self, joint: int) -> float:
        """Metres from `joint` to its parent."""
        return float(np.linalg.norm(self.offsets[joint]))

    def scaled(self, factor: float) -> Skeleton:
        """The same rig, `factor` times as large."""
        return Skeleton(self.names, self.parents, self.offsets * factor, self.end_parents, self.end_offsets * factor)
