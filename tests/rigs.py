"""Variants of rigs for tests: extra bones, another bind pose, other axes, two bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton


def with_bones_above(clip: Clip, above: Mapping[str, str]) -> Clip:
    """Returns the same motion with an extra bone, which never turns, half-way to the parent of each named joint.

    above: by joint, the name of its extra bone.
    """
    skeleton = clip.skeleton
    names, parents, offsets, places = list[str](), list[int](), list[Floats](), list[int]()
    for joint, name in enumerate(skeleton.names):
        parent, offset = (places[skeleton.parents[joint]] if joint else -1), skeleton.offsets[joint]
        if name in above:
            offset = 0.5 * offset
            names.append(above[name])
            parents.append(parent)
            offsets.append(offset)
            parent = len(names) - 1
        places.append(len(names))
        names.append(name)
        parents.append(parent)
        offsets.append(offset)
    ends = np.array(places)[skeleton.end_parents]
    rig = Skeleton(tuple(names), np.array(parents), np.array(offsets), ends, skeleton.end_offsets)
    rotations = np.tile(quaternion.IDENTITY, (clip.frame_count, len(names), 1))
    rotations[:, places] = clip.rotations
    return replace(clip, skeleton=rig, rotations=rotations)


def with_arms_turned(skeleton: Skeleton, radians: float) -> Skeleton:
    """Returns the built-in rig with its arms lowered by `radians` in the bind pose: an A-pose."""
    offsets, ends = skeleton.offsets.copy(), skeleton.end_offsets.copy()
    for side, down in (("Left", -radians), ("Right", radians)):
        arm = skeleton.subtree(skeleton.index(f"{side}Arm"))
        turn = quaternion.about([0.0, 0.0, 1.0], down)
        offsets[arm[1:]] = quaternion.rotate(turn, offsets[arm[1:]])
        tips = np.isin(skeleton.end_parents, arm)
        ends[tips] = quaternion.rotate(turn, ends[tips])
    return replace(skeleton, offsets=offsets, end_offsets=ends)


def with_bind_pose(clip: Clip, turns: Mapping[str, Floats]) -> Clip:
    """Returns the same motion on a rig that is bound in another pose.

    turns: by joint, the rotation [4] in the world that takes the joint and all below it from its bind pose to the other
    one, after the rotations of the joints above.
    """
    skeleton = clip.skeleton
    world = np.tile(quaternion.IDENTITY, (skeleton.joint_count, 1))
    for joint, name in enumerate(skeleton.names):
        above = world[skeleton.parents[joint]] if joint else quaternion.IDENTITY
        world[joint] = quaternion.multiply(turns.get(name, quaternion.IDENTITY), above)
    above = np.concatenate([quaternion.IDENTITY[None], world[skeleton.parents[1:]]])
    rig = replace(
        skeleton,
        offsets=quaternion.rotate(above, skeleton.offsets),
        end_offsets=quaternion.rotate(world[skeleton.end_parents], skeleton.end_offsets),
    )
    rotations = quaternion.multiply(quaternion.multiply(above, clip.rotations), quaternion.conjugate(world))
    return replace(clip, skeleton=rig, rotations=rotations)


def z_up(clip: Clip) -> Clip:
    """Returns the same motion as a file has it in which Z is up and a body faces -Y."""

    def turned(vectors: Floats) -> Floats:
        return np.stack([vectors[..., 0], -vectors[..., 2], vectors[..., 1]], axis=-1)

    rotations = np.concatenate([turned(clip.rotations), clip.rotations[..., 3:]], axis=-1)
    skeleton = replace(
        clip.skeleton, offsets=turned(clip.skeleton.offsets), end_offsets=turned(clip.skeleton.end_offsets)
    )
    return replace(clip, skeleton=skeleton, root_positions=turned(clip.root_positions), rotations=rotations)


def leaning(clip: Clip, radians: float) -> Clip:
    """Returns the motion of a body that leans towards +Z in every frame; by half pi, it lies on its face."""
    rotations = clip.rotations.copy()
    rotations[:, 0] = quaternion.multiply(quaternion.about([1.0, 0.0, 0.0], radians), rotations[:, 0])
    return replace(clip, rotations=rotations)


def two_bodies(clip: Clip, apart: float) -> Clip:
    """Returns two bodies in the same motion below one root, "Reference", the second `apart` metres to the left.

    The second's joints have "B_" before their names.
    """
    skeleton, joints = clip.skeleton, clip.skeleton.joint_count
    second = np.concatenate([[0], skeleton.parents[1:] + 1 + joints])
    offsets = np.concatenate([np.zeros((1, 3)), skeleton.offsets, skeleton.offsets])
    offsets[1], offsets[1 + joints] = 0.0, [apart, 0.0, 0.0]
    both = Skeleton(
        names=("Reference", *skeleton.names, *(f"B_{name}" for name in skeleton.names)),
        parents=np.concatenate([[-1, 0], skeleton.parents[1:] + 1, second]),
        offsets=offsets,
        end_parents=np.concatenate([skeleton.end_parents + 1, skeleton.end_parents + 1 + joints]),
        end_offsets=np.concatenate([skeleton.end_offsets, skeleton.end_offsets]),
    )
    still = np.tile(quaternion.IDENTITY, (clip.frame_count, 1, 1))
    return replace(clip, skeleton=both, rotations=np.concatenate([still, clip.rotations, clip.rotations], axis=1))
