"""The T-pose of a rig whose bind pose may be another one: an A-pose, spread legs, toes that point outwards."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.hand_joints import finger_places, fingers_of, palm_of, wrist_of
from motionsplice.motion.kinematics import bind_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.bind_turns import carry
from motionsplice.motion.retarget.stance import frame, standing_pose
from motionsplice.motion.roles import ARM, LEG, SIDES, Roles, Side, on_side
from motionsplice.motion.skeleton import Skeleton

UP, AHEAD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
OUTWARDS = {"left": np.array([1.0, 0.0, 0.0]), "right": np.array([-1.0, 0.0, 0.0])}
Aims = dict[int, tuple[Floats, Floats]]  # for a joint, its bone [3] in the bind pose, and where it shall point [3]


def t_pose(clip: Clip, roles: Roles) -> Floats:
    """Returns the world rotations [J, 4] of a clip's joints in the T-pose of VRM 1.0.

    The body faces +Z. Legs point down, arms and fingers outwards along X, thumbs between X and Z. Palms face down if
    the rig has fingers. Feet point ahead, as flat as in the standing pose, from which all other joints are taken. Each
    bone takes the shortest way from where the bone above has brought it, so that it keeps its roll.
    """
    skeleton = clip.skeleton
    places, standing = bind_positions(skeleton), standing_pose(skeleton, roles, clip)
    aims: Aims = {}
    fixed: dict[int, Floats] = {}
    for side in SIDES:
        aims |= _limb_aims(places, roles, side)
        aims |= _finger_aims(skeleton, places, roles, side)
        fixed |= _foot(skeleton, places, standing, roles, side)
        if (palm := palm_of(skeleton, roles, side)) is not None:
            turn = quaternion.multiply(frame(OUTWARDS[side], AHEAD), quaternion.conjugate(frame(*palm)))
            fixed[wrist_of(roles, side)] = turn
    turns = standing.copy()
    for joint in range(1, skeleton.joint_count):
        parent = skeleton.parents[joint]
        moved = quaternion.multiply(turns[parent], quaternion.conjugate(standing[parent]))
        turns[joint] = quaternion.multiply(moved, standing[joint])
        if joint in fixed:
            turns[joint] = fixed[joint]
        elif joint in aims:
            turns[joint] = carry(turns[joint], *aims[joint])
    return turns


def _limb_aims(places: Floats, roles: Roles, side: Side) -> Aims:
    return {
        upper: (places[lower] - places[upper], aim)
        for limb, aim in ((LEG, -UP), (ARM, OUTWARDS[side]))
        for upper, lower in pairwise(on_side(roles, side, limb))
    }


def _finger_aims(skeleton: Skeleton, places: Floats, roles: Roles, side: Side) -> Aims:
    """The bone of a finger's last joint leads to its end site."""
    at = {place: joint for joint, place in finger_places(skeleton, fingers_of(skeleton, roles, side)).items()}
    aims: Aims = {}
    for (finger, number), joint in at.items():
        below = at.get((finger, number + 1))
        tips = skeleton.end_offsets[skeleton.end_parents == joint]
        bone = tips.sum(axis=0) if below is None else places[below] - places[joint]
        aims[joint] = bone, OUTWARDS[side] + (finger == "thumb") * AHEAD
    return aims


def _foot(skeleton: Skeleton, places: Floats, standing: Floats, roles: Roles, side: Side) -> dict[int, Floats]:
    """Returns the rotation of an ankle: only about the vertical, because the foot is flat in the standing pose."""
    ankle, toe = on_side(roles, side, ("ankle", "toe"))
    tips = skeleton.end_offsets[skeleton.end_parents == ankle]
    bone = places[toe] - places[ankle] if toe >= 0 else tips.sum(axis=0)
    x, _, z = quaternion.rotate(standing[ankle], bone)
    return {ankle: quaternion.multiply(quaternion.about(UP, -np.arctan2(x, z)), standing[ankle])} if x or z else {}
