"""The standing pose of a rig: upright, facing +Z, legs down.

Most rigs stand in their bind pose, perhaps facing elsewhere. Others have all bones along one axis there, as LAFAN1's
BVH files and 3ds Max's Biped do: their standing pose is found from a motion. So are feet that are bound pointing down.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import bind_positions, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.segments import segments_of
from motionsplice.motion.roles import ARM, LEG, SIDES, Roles, Side, common_ancestor, on_side
from motionsplice.motion.skeleton import Skeleton

UP, LEFT = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
LEAST_TURN = np.radians(5.0)  # a bind pose within this of +Z faces +Z: hips are seldom exactly symmetric
LEAST_DOWN = 0.5  # cosine of the angle between a thigh and straight down: with less, the bind pose does not stand
SHORTEST = 1e-9  # metres: a shorter line has no direction
LEAST_BEND = 0.05  # mean sine of the bend: a limb that bends less does not show its hinge
FAR = np.radians(45.0)  # a joint whose mean is nearer to its bind rotation has that rotation in the standing pose
FREE = ("trunk", "neck", "head", "collar", "hand")  # segments whose joints may be far from their bind rotation
LEAST_ON_FLOOR = 0.3  # of a foot's length: a foot that is shorter over the floor shows no direction
LOWEST = 30.0  # percent of the frames, those in which an ankle is lowest: there the foot is flat


def stands(skeleton: Skeleton, roles: Roles) -> bool:
    """Returns whether the thighs point down in the bind pose, once it is turned upright."""
    at = bind_positions(skeleton)
    thighs = at[[roles.left_knee, roles.right_knee]] - at[[roles.left_hip, roles.right_hip]]
    down = -quaternion.rotate(_upright(skeleton, roles), thighs)[:, 1]
    return bool(np.all(down >= LEAST_DOWN * np.linalg.norm(thighs, axis=1)))


@lru_cache(maxsize=16)
def shown_by_motion(skeleton: Skeleton, roles: Roles) -> bool:
    """Returns whether the bind pose does not show the standing pose, so that a motion has to."""
    return not stands(skeleton, roles) or bool(_steep_feet(skeleton, roles, _upright(skeleton, roles)))


def standing_pose(skeleton: Skeleton, roles: Roles, motion: Clip | None = None) -> Floats:
    """Returns the world rotations of the joints [J, 4] in the standing pose.

    These are the bind pose's, turned upright and to +Z. If its legs do not point down then, they are found from
    `motion`, a clip of this skeleton, if there is one. Limbs are turned to a T-pose by the axes about which knees and
    elbows bend; if they do not bend, they have their mean. Feet are as where they stand. Other joints keep their bind
    rotation to their parent, except joints of trunk, neck, collars and hands that are usually far from it: these have
    their mean. If only feet point down in the bind pose, they alone are found from the motion.
    """
    pose = np.tile(_upright(skeleton, roles), (skeleton.joint_count, 1))
    standing = stands(skeleton, roles)
    sides = _steep_feet(skeleton, roles, pose[0]) if standing else SIDES
    if motion is None or not sides:
        return pose
    moved = world_transforms(skeleton, motion.root_positions, motion.rotations)
    feet = _feet(skeleton, roles, *moved, pose[0], sides)
    if standing:
        pose[list(feet)] = list(feet.values())
        return pose
    found = _limbs(skeleton, roles, *moved, pose[0]) | feet
    segments = segments_of(skeleton, roles)
    free = {joint for name in segments if name.endswith(FREE) for joint in segments[name].joints}
    for joint, parent in enumerate(skeleton.parents.tolist()[1:], 1):
        pose[joint] = found.get(joint, pose[parent])
        if joint in free and quaternion.angle(mean := _mean(motion.rotations[:, joint]), quaternion.IDENTITY) > FAR:
            pose[joint] = quaternion.multiply(pose[parent], mean)
    return pose


def ahead(skeleton: Skeleton, joint: int) -> Floats:
    """Returns the mean vector [3] from a joint to its children, or else to its end sites, in the bind pose."""
    below = [skeleton.offsets[child] for child in skeleton.children[joint]]
    below = below or list(skeleton.end_offsets[skeleton.end_parents == joint])
    return np.mean(below, axis=0) if below else np.zeros(3)


def heading(foot: Floats) -> float | None:
    """Returns the angle on the floor from +Z to a foot [3]; None if the foot is too steep to show one."""
    if np.hypot(foot[0], foot[2]) <= LEAST_ON_FLOOR * np.linalg.norm(foot):
        return None
    return float(np.arctan2(foot[0], foot[2]))


def _steep_feet(skeleton: Skeleton, roles: Roles, body: Floats) -> list[Side]:
    """Returns the sides whose foot points down in the bind pose; `body` [4] turns it upright."""
    feet = {side: quaternion.rotate(body, ahead(skeleton, getattr(roles, f"{side}_ankle"))) for side in SIDES}
    return [side for side, foot in feet.items() if np.any(foot) and heading(foot) is None]


def _feet(
    skeleton: Skeleton, roles: Roles, positions: Floats, world: Floats, body: Floats, sides: Sequence[Side]
) -> dict[int, Floats]:
    """Returns the rotations [4] of the feet's joints as they stand in a motion.

    positions, world: [F, J, 3] and [F, J, 4] of the joints in the motion. body: [4] the root's in the standing pose.
    """
    found = {}
    for side in sides:
        ankle = int(getattr(roles, f"{side}_ankle"))
        height = positions[:, ankle, 1]
        flat = height <= np.percentile(height, LOWEST)
        for joint in skeleton.subtree(ankle):
            found[joint] = quaternion.multiply(body, _mean_on_root(world[flat], joint))
    return found


def _limbs(skeleton: Skeleton, roles: Roles, positions: Floats, world: Floats, body: Floats) -> dict[int, Floats]:
    """Returns the rotations [4] of hips and shoulders in the standing pose, and of knees and elbows that do not bend.

    positions, world, body: as in `_feet`.
    """
    rest, found = bind_positions(skeleton), {}
    for side in SIDES:
        outwards = LEFT if side == "left" else -LEFT
        for limb, along, hinge in ((LEG, -UP, LEFT), (ARM, outwards, -outwards[0] * UP)):
            joints = on_side(roles, side, limb)
            upper, middle, _ = joints
            axes = _hinge(positions[:, joints])
            axis = quaternion.rotate(quaternion.conjugate(world[:, upper]), axes).mean(axis=0)
            bone = rest[middle] - rest[upper]
            if np.linalg.norm(np.cross(bone, axis)) > LEAST_BEND * np.linalg.norm(bone):
                found[upper] = quaternion.multiply(frame(along, hinge), quaternion.conjugate(frame(bone, axis)))
            else:
                found |= {joint: quaternion.multiply(body, _mean_on_root(world, joint)) for joint in (upper, middle)}
    return found


def frame(along: Floats, across: Floats) -> Floats:
    """Returns the rotation [4] of the frame whose x points along a vector [3], and y across it, towards another."""
    x = along / np.linalg.norm(along)
    y = across - x * (x @ across)
    y = y / np.linalg.norm(y)
    return quaternion.from_matrices(np.stack([x, y, np.cross(x, y)], axis=-1))


def _hinge(limb: Floats) -> Floats:
    """Returns the axis [F, 3] about which a limb bends, as long as the sine of the bend, from its joints [F, 3, 3]."""
    bones = quaternion.unit(np.diff(limb, axis=1))
    return np.cross(bones[:, 0], bones[:, 1])


def _upright(skeleton: Skeleton, roles: Roles) -> Floats:
    """Returns the rotation [4] that turns the bind pose upright and to +Z; the identity if it shows no direction.

    Up is the axis nearest to the trunk, since trunks lean a little on every rig.
    """
    at = bind_positions(skeleton)
    chest = common_ancestor(skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    trunk = at[chest] - 0.5 * (at[roles.left_hip] + at[roles.right_hip])
    axis = int(np.argmax(np.abs(trunk)))
    up = np.sign(trunk[axis]) * np.eye(3)[axis]
    left = at[roles.left_hip] - at[roles.right_hip]
    left = left - up * (up @ left)
    width = float(np.linalg.norm(left))
    if not np.any(up) or width < SHORTEST:
        return quaternion.IDENTITY
    left = left / width
    turn = quaternion.from_matrices(np.stack([left, up, np.cross(left, up)]))
    return turn if quaternion.angle(turn, quaternion.IDENTITY) > LEAST_TURN else quaternion.IDENTITY


def _mean_on_root(world: Floats, joint: int) -> Floats:
    """Returns the mean rotation [4] of a joint as seen from the root, of world rotations [F, J, 4]."""
    return _mean(quaternion.multiply(quaternion.conjugate(world[:, 0]), world[:, joint]))


def _mean(rotations: Floats) -> Floats:
    """Returns the mean of rotations [n, 4], the one with the least sum of squared chords (Markley et al. 2007)."""
    return np.asarray(np.linalg.eigh(rotations.T @ rotations)[1][:, -1])
