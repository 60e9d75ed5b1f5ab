"""The finger joints of a rig: which is which, how they match another rig's, and how they are added to a rig."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from functools import lru_cache

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import IDENTITY, Floats, angle, rotate, unit
from motionsplice.motion.role_names import words_of
from motionsplice.motion.roles import SIDES, Roles, Side
from motionsplice.motion.skeleton import Integers, Skeleton

FINGER = re.compile(r"(thumb|index|middle|mid|ring(?!pinky)|pinky|little)\D*(\d*)")
HAND = re.compile(FINGER.pattern + "|finger")
FEWEST_TIPS = 3
SAME_FINGER = {"mid": "middle", "little": "pinky"}
STRAIGHT = 1e-6  # sine of the angle to Z below which a forearm counts as pointing ahead
ALIKE = 0.1  # radians: bind poses that differ by less count as equal, because hands differ in shape


def wrist_of(roles: Roles, side: Side) -> int:
    """Returns the joint of the wrist."""
    return int(getattr(roles, f"{side}_wrist"))


def elbow_of(roles: Roles, side: Side) -> int:
    """Returns the joint of the elbow."""
    return int(getattr(roles, f"{side}_elbow"))


def forearm_of(skeleton: Skeleton, roles: Roles, side: Side) -> list[int]:
    """Returns the joints from elbow to wrist, both included, with any twist bones between."""
    path = skeleton.chain(wrist_of(roles, side))
    return path[: path.index(elbow_of(roles, side)) + 1][::-1]


def forearm(skeleton: Skeleton, roles: Roles, side: Side) -> Floats:
    """Returns the vector from elbow to wrist [3], metres, in the bind pose. Raises SkeletonError if it is zero."""
    bone = np.asarray(skeleton.offsets[forearm_of(skeleton, roles, side)[1:]].sum(axis=0))
    if not np.any(bone):
        raise SkeletonError(f"the {side} forearm has no length", mend="Name the elbow and wrist as roles")
    return bone


def ahead_of(bone: Floats) -> Floats:
    """Returns the unit vector [3] perpendicular to a forearm [3] that points most nearly ahead (+Z), or else up.

    In a bind pose, the thumb's side of the wrist is there.
    """
    along = bone / np.linalg.norm(bone)
    ahead = np.array([0.0, 0.0, 1.0]) - along * along[2]
    size = float(np.linalg.norm(ahead))
    return ahead / size if size > STRAIGHT else np.array([0.0, 1.0, 0.0])


def fingers_of(skeleton: Skeleton, roles: Roles, side: Side) -> list[int]:
    """Returns the joints from a wrist to its fingertips, without the wrist, in order; none for fewer than three tips.

    Fingers are found by name. If no joint has a finger's name, these are all descendants of the wrist.
    """
    joints = _named_fingers(skeleton, wrist_of(roles, side)) or skeleton.subtree(wrist_of(roles, side))[1:]
    tips = set(joints) - {int(skeleton.parents[joint]) for joint in joints}
    return joints if len(tips) >= FEWEST_TIPS else []


def _named_fingers(skeleton: Skeleton, wrist: int) -> list[int]:
    """Returns the joints below a wrist that have a finger's name, and those between, in order."""
    below = skeleton.subtree(wrist)[1:]
    fingers = [joint for joint in below if HAND.search(_spelled(skeleton.names[joint]))]
    paths = {ancestor for joint in fingers for ancestor in skeleton.chain(joint)}
    return [joint for joint in below if joint in paths]


def _spelled(name: str) -> str:
    """Returns a joint's name in lower case without separators and side: "LeftHandIndex1" gives "handindex1"."""
    return "".join(words_of(name)[0])


@lru_cache(maxsize=16)
def has_fingers(skeleton: Skeleton, roles: Roles) -> bool:
    """Returns whether either hand has fingers. A mitten, with or without a thumb, does not count."""
    return any(fingers_of(skeleton, roles, side) for side in SIDES)


def palm_of(skeleton: Skeleton, roles: Roles, side: Side) -> tuple[Floats, Floats] | None:
    """Returns the vectors from the wrist to the knuckles and across them, from little to index finger, each [3] metres.

    They are those of the bind pose. None if the rig has no index finger or no other finger with a known name.
    """
    wrist = wrist_of(roles, side)
    knuckles: dict[str, tuple[int, Floats]] = {}
    for joint, (finger, place) in finger_places(skeleton, fingers_of(skeleton, roles, side)).items():
        if finger != "thumb" and place > 0 and (finger not in knuckles or place < knuckles[finger][0]):
            path = skeleton.chain(joint)
            knuckles[finger] = place, skeleton.offsets[path[: path.index(wrist)]].sum(axis=0)
    across = [knuckles[finger][1] for finger in ("index", "middle", "ring", "pinky") if finger in knuckles]
    if len(across) < 2 or "index" not in knuckles:
        return None
    along, line = np.mean(across, axis=0), across[0] - across[-1]
    return (along, line) if np.linalg.norm(np.cross(along, line)) > STRAIGHT * np.linalg.norm(along) ** 2 else None


def match_fingers(ours: Skeleton, our_roles: Roles, theirs: Skeleton, their_roles: Roles, side: Side) -> dict[int, int]:
    """Returns the joint of their hand for each joint of ours, matched by name, or else by order if the trees are equal.

    Joints of ours without a match, such as metacarpals, are left out. Raises SkeletonError if nothing matches.
    """
    mine, other = fingers_of(ours, our_roles, side), fingers_of(theirs, their_roles, side)
    by_place = {place: joint for joint, place in finger_places(theirs, other).items()}
    match = {joint: by_place[place] for joint, place in finger_places(ours, mine).items() if place in by_place}
    if not match and _shape(ours, mine) == _shape(theirs, other):
        match = dict(zip(mine, other, strict=True))
    if mine and not other:
        mend = "Export the hands with their fingers, or use the other hand only"
        raise SkeletonError(f"the hands' rig has no fingers on its {side} hand", mend=mend)
    if mine and not match:
        raise SkeletonError(
            f"no finger of the {side} hand ({ours.names[mine[0]]!r} ...) matches the hands' rig",
            mend="Name the fingers thumb, index, middle, ring and pinky, with numbers counted from the palm",
        )
    return match


def finger_places(skeleton: Skeleton, joints: list[int]) -> dict[int, tuple[str, int]]:
    """Returns the finger and the place in it, counted from 1 at the palm, of the joints that have a finger's name.

    The place is the number in the name, or the order of the joints if no joint of the finger has one. Bones within the
    palm have place 0.
    """
    found = {joint: FINGER.search(_spelled(skeleton.names[joint])) for joint in joints}
    named = {joint: (SAME_FINGER.get(name[1], name[1]), name[2]) for joint, name in found.items() if name is not None}
    numbered = {finger for finger, number in named.values() if number}
    places: dict[int, tuple[str, int]] = {}
    for joint, (finger, number) in named.items():
        palm = finger in numbered or (finger != "thumb" and "metacarpal" in skeleton.names[joint].lower())
        before = sum(other == finger and place > 0 for other, place in places.values())
        places[joint] = finger, int(number) if number else 0 if palm else 1 + before
    return places


def _shape(skeleton: Skeleton, joints: list[int]) -> list[int]:
    """Returns the place of each joint's parent in `joints`, -1 for a parent outside: equal lists are equal trees."""
    return [joints.index(int(skeleton.parents[joint])) if skeleton.parents[joint] in joints else -1 for joint in joints]


def bind_turn(ours: Skeleton, our_roles: Roles, theirs: Skeleton, their_roles: Roles, side: Side) -> Floats:
    """Returns the rotation [4] that best lays their hand on ours, both in their bind poses.

    Fitted to the forearm and the fingers, or, if our hand has no fingers, to the forearm and the direction ahead of it.
    The identity if the rotation is below 0.1 radians.
    """
    arms = forearm(ours, our_roles, side), forearm(theirs, their_roles, side)
    bones = [arms]
    if fingers_of(ours, our_roles, side):
        match = match_fingers(ours, our_roles, theirs, their_roles, side)
        bones += [(ours.offsets[mine], theirs.offsets[other]) for mine, other in match.items()]
    else:
        bones.append((ahead_of(arms[0]), ahead_of(arms[1])))
    turn = horn_rotation([unit(mine) for mine, _ in bones], [unit(other) for _, other in bones])
    return turn if angle(turn, IDENTITY) > ALIKE else IDENTITY


def graft_fingers(
    skeleton: Skeleton, roles: Roles, theirs: Skeleton, their_roles: Roles
) -> tuple[Skeleton, Roles, Integers]:
    """Adds the fingers of another rig to a rig without fingers, scaled by the length of the forearms.

    Returns the new rig, its roles, and the new index [J] of each joint. A mitten's joints are replaced by the fingers:
    their index is -1, and the nearest joint above adopts their other children. Raises SkeletonError if the other rig
    has no fingers either.
    """
    if not has_fingers(theirs, their_roles):
        raise SkeletonError("neither the body nor the hands have fingers", mend="Export the hands with their fingers")
    sides = {wrist_of(roles, side): side for side in SIDES}
    mittens = {joint for wrist in sides for joint in _named_fingers(skeleton, wrist)}
    used = {name for joint, name in enumerate(skeleton.names) if joint not in mittens}
    names: list[str] = []
    parents: list[int] = []
    offsets: list[Floats] = []
    ends: list[tuple[int, Floats]] = []
    places = np.full(skeleton.joint_count, -1)
    for joint in range(skeleton.joint_count):
        if joint in mittens:
            continue
        above, offset = int(skeleton.parents[joint]), skeleton.offsets[joint]
        while above in mittens:
            above, offset = int(skeleton.parents[above]), offset + skeleton.offsets[above]
        places[joint] = len(names)
        names.append(skeleton.names[joint])
        parents.append(int(places[above]) if joint else -1)
        offsets.append(offset)
        if joint not in sides:
            ends += [(int(places[joint]), offset) for offset in skeleton.end_offsets[skeleton.end_parents == joint]]
            continue
        wrist = wrist_of(their_roles, sides[joint])
        turn = bind_turn(skeleton, roles, theirs, their_roles, sides[joint])
        ours, other = (forearm(*rig, sides[joint]) for rig in ((skeleton, roles), (theirs, their_roles)))
        size = np.linalg.norm(ours) / np.linalg.norm(other)
        at = {wrist: int(places[joint])}
        for finger in fingers_of(theirs, their_roles, sides[joint]):
            at[finger], name = len(names), theirs.names[finger]
            names.append(name if name not in used else f"{sides[joint]}:{name}")
            parents.append(at[int(theirs.parents[finger])])
            offsets.append(size * rotate(turn, theirs.offsets[finger]))
            tips = theirs.end_offsets[theirs.end_parents == finger]
            ends += [(at[finger], size * rotate(turn, tip)) for tip in tips]
    rig = Skeleton(
        names=tuple(names),
        parents=np.array(parents),
        offsets=np.array(offsets),
        end_parents=np.array([parent for parent, _ in ends], np.int64),
        end_offsets=np.array([offset for _, offset in ends]).reshape(-1, 3),
    )
    return rig, moved_roles(roles, places), places


def fingered(clip: Clip, roles: Roles, theirs: Skeleton, their_roles: Roles) -> tuple[Clip, Roles]:
    """Returns the clip and its roles, with the other rig's fingers added, straight, if the clip's rig has none.

    Raises SkeletonError if neither rig has fingers.
    """
    if has_fingers(clip.skeleton, roles):
        return clip, roles
    skeleton, moved, places = graft_fingers(clip.skeleton, roles, theirs, their_roles)
    rotations = np.tile(IDENTITY, (clip.frame_count, skeleton.joint_count, 1))
    rotations[:, places[places >= 0]] = clip.rotations[:, places >= 0]
    return replace(clip, skeleton=skeleton, rotations=rotations), moved


def moved_roles(roles: Roles, places: Integers) -> Roles:
    """Returns the roles after the joints have moved to the indices `places` [J]."""

    def place(joint: int) -> int:
        return int(places[joint]) if joint >= 0 else -1

    moved = {role.name: place(getattr(roles, role.name)) for role in fields(Roles) if role.name != "spine"}
    return replace(roles, **moved, spine=tuple(place(joint) for joint in roles.spine))
