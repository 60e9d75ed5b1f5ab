"""Retargeting: the motion of one rig on another, matched by the roles of their joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.hand_joints import fingers_of, match_fingers, wrist_of
from motionsplice.motion.kinematics import bind_positions, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.bind_turns import Standing, bind_turns, carry
from motionsplice.motion.retarget.segments import LIMBS
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import SIDES, Roles
from motionsplice.motion.skeleton import Skeleton

STILL = np.radians(1.0)  # a joint that turns less on its parent over the whole clip does not move


@dataclass(frozen=True, eq=False)
class Retargeted:
    """A clip that was carried over to another rig.

    Attributes:
        clip: The clip on that rig.
        left_out: The names of its joints that move and have no counterpart there.
    """

    clip: Clip
    left_out: tuple[str, ...]


def retarget(
    clip: Clip, roles: Roles, skeleton: Skeleton, skeleton_roles: Roles, pose: Floats | None = None
) -> Retargeted:
    """Carries a motion over to a rig of other names, topology, proportions and bind pose.

    Limbs, hands and fingers point as in the clip. Trunk, neck, head, collars and feet turn as far from the rig's
    standing pose as the clip's do from theirs. Rotations of spines, necks and collars with another number of joints are
    interpolated along their length. Joints without a role keep their bind rotation to their parent. The path of the
    middle of the hips is scaled by the ratio of the leg lengths.

    Args:
        clip: The motion.
        roles: The roles of its joints.
        skeleton: The rig onto which the motion goes.
        skeleton_roles: The roles of that rig's joints.
        pose: [J, 4] that rig's `standing_pose`; None to find it from the bind pose alone.

    Returns:
        The clip on the rig, and what it does not show.

    Raises:
        SkeletonError: The legs of the clip's rig have no length.

    Example:
        ```python
        from motionsplice import find_roles, retarget
        from motionsplice.motion.procedural.hand_rig import FINGERED
        from motionsplice.motion.procedural.library import make

        walk = make("walk")
        moved = retarget(walk, find_roles(walk.skeleton), FINGERED, find_roles(FINGERED))
        print(moved.clip.skeleton.joint_count, moved.left_out)
        ```
    """
    their_leg = roles.leg_length(clip.skeleton)
    if their_leg <= 0.0:
        problem, mend = "its legs have no length", "Name hips, knees and ankles in a file and pass it as --roles"
        raise SkeletonError(problem, place=f"clip {clip.name!r}", mend=mend)
    theirs = Standing(clip.skeleton, roles, standing_pose(clip.skeleton, roles, clip))
    ours = Standing(skeleton, skeleton_roles, standing_pose(skeleton, skeleton_roles) if pose is None else pose)
    turns = bind_turns(theirs, ours)
    at, turned = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    world = dict(_segments(at, turned, turns, theirs, ours))
    carried = {joint for name in turns for joint in theirs.segments[name].joints}
    for joint, other, turn in _fingers(turns, theirs, ours):
        world[joint] = quaternion.multiply(turned[:, other], turn)
        carried.add(other)
    scale = skeleton_roles.leg_length(skeleton) / their_leg
    rest = bind_positions(skeleton)
    middle = 0.5 * (rest[skeleton_roles.left_hip] + rest[skeleton_roles.right_hip])
    hips = 0.5 * (at[:, roles.left_hip] + at[:, roles.right_hip])
    moved = replace(
        clip,
        skeleton=skeleton,
        root_positions=scale * hips - quaternion.rotate(world[0], middle),
        rotations=_local(world, skeleton),
    )
    return Retargeted(moved, _moving(clip, carried))


def _segments(
    at: Floats, turned: Floats, turns: dict[str, Floats], theirs: Standing, ours: Standing
) -> Iterator[tuple[int, Floats]]:
    """Yields our joints that lie in a segment, with their world rotations [F, 4].

    at, turned: their joints' positions [F, J, 3] and rotations [F, J, 4] in the world.
    """
    for name, turn in turns.items():
        segment, other = ours.segments[name], theirs.segments[name]
        joints, their_joints = list(segment.joints), list(other.joints)
        from_standing = quaternion.multiply(turned[:, their_joints], quaternion.conjugate(theirs.pose[their_joints]))
        found = _along(from_standing, other.places, segment.places)
        found = quaternion.multiply(quaternion.multiply(found, turn), ours.pose[joints])
        if name.endswith(LIMBS):  # joints between its ends may bend a limb, on their rig or on ours
            bones = ours.skeleton.offsets[[*joints[1:], segment.end]]
            limb = quaternion.rotate(found, bones).sum(axis=1)
            straight = quaternion.between(limb, at[:, other.end] - at[:, other.joints[0]])
            found = quaternion.multiply(straight[:, None], found)
        for place, joint in enumerate(joints):
            yield joint, found[:, place]


def _along(rotations: Floats, places: Floats, wanted: Floats) -> Floats:
    """Interpolates rotations [F, n, 4] at `places` [n] of a segment at the places `wanted` [m]. -> [F, m, 4]."""
    if len(places) == 1:
        return np.repeat(rotations, len(wanted), axis=1)
    after = np.clip(np.searchsorted(places, wanted, side="right"), 1, len(places) - 1)
    before = after - 1
    gaps = np.maximum(places[after] - places[before], 1e-12)
    parts = np.clip((wanted - places[before]) / gaps, 0.0, 1.0)
    return quaternion.slerp(rotations[:, before], rotations[:, after], parts)


def _fingers(turns: dict[str, Floats], theirs: Standing, ours: Standing) -> Iterator[tuple[int, int, Floats]]:
    """Yields our finger joints with theirs and the constant rotation [4] from their joint's axes to ours."""
    for side in SIDES:
        if not all(fingers_of(rig.skeleton, rig.roles, side) for rig in (theirs, ours)):
            continue
        try:
            match = match_fingers(ours.skeleton, ours.roles, theirs.skeleton, theirs.roles, side)
        except SkeletonError:  # fingers with unknown names keep their bind pose
            continue
        found = {wrist_of(ours.roles, side): turns[f"{side}_hand"][0]}
        for joint, other in match.items():
            above = next(found[up] for up in ours.skeleton.chain(joint) if up in found)
            found[joint] = carry(above, ours.ahead(joint), theirs.ahead(other))
            turn = quaternion.multiply(quaternion.conjugate(theirs.pose[other]), found[joint])
            yield joint, other, quaternion.multiply(turn, ours.pose[joint])


def _local(world: dict[int, Floats], skeleton: Skeleton) -> Floats:
    """Returns local rotations [F, J, 4], from the world rotations of some joints. The others stay as in the bind pose.

    The root must be among them.
    """
    local = np.tile(quaternion.IDENTITY, (len(world[0]), skeleton.joint_count, 1))
    local[:, 0] = world[0]
    turned = dict(world)
    for joint, parent in enumerate(skeleton.parents.tolist()[1:], 1):
        if joint in world:
            local[:, joint] = quaternion.multiply(quaternion.conjugate(turned[parent]), world[joint])
        else:
            turned[joint] = turned[parent]
    return quaternion.one_hemisphere(local)


def _moving(clip: Clip, carried: set[int]) -> tuple[str, ...]:
    """Returns the names of the joints that turn on their parents and are not carried over."""
    names = clip.skeleton.names
    rest = [joint for joint in range(len(names)) if joint not in carried]
    angles = quaternion.angle(clip.rotations[:, rest], clip.rotations[:1, rest]).max(axis=0)
    return tuple(names[joint] for joint, angle in zip(rest, angles, strict=True) if angle > STILL)
