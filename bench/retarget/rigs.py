"""The built-in motions on other rigs: with other names, spines, extra bones, bind poses and proportions.

A joint's world rotation, relative to its bind pose, is that of the built-in joint. So the motion on each rig is the
truth for motions that are retargeted to it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import local_rotations, world_transforms
from motionsplice.motion.procedural.hand_rig import with_fingers
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton

TRUNK = ("Spine", "Spine1", "Spine2")  # the built-in joints from the pelvis to the chest


@dataclass(frozen=True)
class Kind:
    """A kind of rig, in terms of the built-in one.

    name: returns a joint's name from its built-in name; "" leaves out the joint and those below it.
    trunk: the names of the joints from the pelvis to the chest, evenly spaced.
    bind: returns the world rotation [4] of a built-in joint in this rig's bind pose, relative to the T-pose.
    between: names of extra bones, which begin in the middle of a bone, by the built-in name of the joint at its end.
    sizes: lengths of bones relative to the built-in rig's, by the built-in name of the joint at the end, without side.
    """

    name: Callable[[str], str]
    trunk: tuple[str, ...]
    bind: Callable[[str], Floats]
    between: Mapping[str, str] = field(default_factory=dict)
    sizes: Mapping[str, float] = field(default_factory=dict)


@dataclass
class _Joints:
    """The joints of a rig as it grows: their names, parents, T-pose offsets, and built-in joints that turn alike."""

    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[Floats] = field(default_factory=list)
    sources: list[int] = field(default_factory=list)
    places: dict[int, int] = field(default_factory=dict)  # by built-in joint

    def add(self, name: str, parent: int, offset: Floats, source: int) -> int:
        self.names.append(name)
        self.parents.append(parent)
        self.offsets.append(offset)
        self.sources.append(source)
        return len(self.names) - 1


def on_rig(clip: Clip, kind: Kind) -> Clip:
    """Returns a built-in clip on a rig of another kind."""
    clip = with_fingers(clip)
    rig, joints = clip.skeleton, _joints(clip.skeleton, kind)
    _, world = world_transforms(rig, clip.root_positions, clip.rotations)
    binds = np.array([kind.bind(rig.names[source]) for source in joints.sources])
    turned = quaternion.multiply(world[:, joints.sources], quaternion.conjugate(binds))
    ends = [end for end, joint in enumerate(rig.end_parents) if int(joint) in joints.places]
    end_parents = np.array([joints.places[int(rig.end_parents[end])] for end in ends])
    skeleton = Skeleton(
        names=tuple(joints.names),
        parents=np.array(joints.parents),
        offsets=quaternion.rotate(binds[np.maximum(joints.parents, 0)], joints.offsets),
        end_parents=end_parents,
        end_offsets=quaternion.rotate(binds[end_parents], rig.end_offsets[ends]),
    )
    leg = 0.5 * (kind.sizes.get("Leg", 1.0) + kind.sizes.get("Foot", 1.0))
    rotations = quaternion.one_hemisphere(local_rotations(skeleton, turned))
    return Clip(clip.name, skeleton, clip.rate, clip.root_positions * leg, rotations)


def _joints(rig: Skeleton, kind: Kind) -> _Joints:
    joints, trunk = _Joints(), [rig.index(name) for name in TRUNK]
    for joint, name in enumerate(rig.names):
        parent, size = int(rig.parents[joint]), kind.sizes.get(re.sub("^(Left|Right)", "", name), 1.0)
        if joint == trunk[0]:
            joints.places[trunk[-1]] = _add_trunk(joints, rig, kind.trunk, trunk)
        if joint in trunk or not kind.name(name) or (parent >= 0 and parent not in joints.places):
            continue
        above, offset = joints.places.get(parent, -1), rig.offsets[joint] * size
        if name in kind.between:
            above, offset = joints.add(kind.between[name], above, 0.5 * offset, parent), 0.5 * offset
        joints.places[joint] = joints.add(kind.name(name), above, offset, joint)
    return joints


def _add_trunk(joints: _Joints, rig: Skeleton, names: tuple[str, ...], trunk: list[int]) -> int:
    """Adds the joints of the trunk, each turning like the nearest built-in one. Returns the chest."""
    above, offset = 0, rig.offsets[trunk[0]]
    for number, name in enumerate(names):
        nearest = round(number * (len(trunk) - 1) / (len(names) - 1))
        above = joints.add(name, above, offset, trunk[nearest])
        offset = rig.offsets[trunk[1:]].sum(axis=0) / (len(names) - 1)
    return above
