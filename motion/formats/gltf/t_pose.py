"""The T-pose of a rig whose bind pose may be another one: an A-pose, spread legs, toes that point outwards."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.hand_joints import SIDES, Side, finger_places, fingers_of, wrist_of
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton

UP, AHEAD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
OUTWARDS = {"left": np.array([1.0, 0.0, 0.0]), "right": np.array([-1.0, 0.0, 0.0])}
FINGERS = ("index", "middle", "ring", "pinky")
Aims = dict[int, tuple[Floats, Floats]]  # for a joint, its bone [3] in the bind pose, and where it points [3]


def t_pose(skeleton: Skeleton, roles: Roles) -> Floats:
    """Returns the world rotations [J, 4] that bring a rig from its bind pose into the T-pose of VRM 1.0.

    The body faces +Z. Legs point down, arms and fingers outwards along X, thumbs between X and Z. Palms face down if
    the rig has fingers. Feet point ahead, as flat as in the bind pose. Trunk, collars, neck and head keep their bind
    pose. Each bone takes the shortest way from where the bone above has brought it, so that it keeps its roll.
    """
    places = bind_positions(skeleton)
    facing = quaternion.about(UP, -heading(places[roles.left_hip] - places[roles.right_hip]))
    aims: Aims = {}
    fixed: dict[int, Floats] = {}
    for side in SIDES:
        aims |= _limb_aims(places, roles, side)
        aims |= _finger_aims(skeleton, places, roles, side)
        fixed |= _foot(skeleton, places, roles, side)
        fixed |= _hand(skeleton, places, roles, side)
    turns = np.tile(facing, (skeleton.joint_count, 1))
    for joint in range(1, skeleton.joint_count):
        above = turns[skeleton.parents[joint]]
        bone, aim = aims.get(joint, (UP, UP))
        if joint in fixed:
            turns[joint] = fixed[joint]
        elif joint in aims and np.any(bone):
            turns[joint] = quaternion.multiply(quaternion.between(quaternion.rotate(above, bone), aim), above)
        else:
            turns[joint] = above
    return turns


def bind_positions(skeleton: Skeleton) -> Floats:
    """Returns the positions of the joints [J, 3] in the bind pose, metres from the root."""
    places = np.zeros((skeleton.joint_count, 3))
    for joint in range(1, skeleton.joint_count):
        places[joint] = places[skeleton.parents[joint]] + skeleton.offsets[joint]
    return places


def _limb_aims(places: Floats, roles: Roles, side: Side) -> Aims:
    hip, knee, ankle, shoulder, elbow, wrist = (
        int(getattr(roles, f"{side}_{part}")) for part in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
    )
    down, outwards = (hip, knee, ankle), (shoulder, elbow, wrist)
    return {
        upper: (places[lower] - places[upper], aim)
        for limb, aim in ((down, -UP), (outwards, OUTWARDS[side]))
        for upper, lower in pairwise(limb)
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


def _foot(skeleton: Skeleton, places: Floats, roles: Roles, side: Side) -> dict[int, Floats]:
    """Returns the rotation of an ankle: only about the vertical, because the foot is flat in the bind pose."""
    ankle, toe = (int(getattr(roles, f"{side}_{part}")) for part in ("ankle", "toe"))
    tips = skeleton.end_offsets[skeleton.end_parents == ankle]
    x, _, z = places[toe] - places[ankle] if toe >= 0 else tips.sum(axis=0)
    return {ankle: quaternion.about(UP, -np.arctan2(x, z))} if x or z else {}


def _hand(skeleton: Skeleton, places: Floats, roles: Roles, side: Side) -> dict[int, Floats]:
    """Returns the rotation of a wrist, by the knuckles; none if the hand lacks some."""
    wrist = wrist_of(roles, side)
    found = finger_places(skeleton, fingers_of(skeleton, roles, side))
    knuckles = {finger: places[joint] - places[wrist] for joint, (finger, place) in found.items() if place == 1}
    if not set(FINGERS) <= knuckles.keys():
        return {}
    along = np.mean([knuckles[finger] for finger in FINGERS], axis=0)
    bound, aimed = _axes(along, knuckles["index"] - knuckles["pinky"]), _axes(OUTWARDS[side], AHEAD)
    return {wrist: quaternion.from_matrices(aimed @ bound.T)}


def _axes(along: Floats, across: Floats) -> Floats:
    """Returns three axes as columns [3, 3]: along, across made perpendicular to it, and perpendicular to both."""
    x = along / np.linalg.norm(along)
    z = np.cross(x, across)
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)
