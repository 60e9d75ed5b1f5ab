"""The joints of a rig's hands: which finger is which, and how those of one rig sit on another."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from typing import Literal

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import IDENTITY, Floats, angle, rotate
from motionsplice.motion.role_names import side_and_part
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Integers, Skeleton

Side = Literal["left", "right"]
SIDES: tuple[Side, ...] = ("left", "right")
FINGER = re.compile(r"(thumb|index|middle|mid|ring|pinky|little)\D*(\d*)")
HAND = re.compile(FINGER.pattern + "|finger")
FEWEST_TIPS = 3
SAME_FINGER = {"mid": "middle", "little": "pinky"}
STRAIGHT = 1e-6  # of a forearm's length, by which one that points ahead may miss
ALIKE = 0.1  # radians: bind poses of hands that are nearer count as one, for hands are not all of one shape


def wrist_of(roles: Roles, side: Side) -> int:
    return int(getattr(roles, f"{side}_wrist"))


def elbow_of(roles: Roles, side: Side) -> int:
    return int(getattr(roles, f"{side}_elbow"))


def forearm_of(skeleton: Skeleton, roles: Roles, side: Side) -> list[int]:
    """The joints from elbow to wrist, both included: a rig may have bones between, which twist."""
    way = skeleton.chain(wrist_of(roles, side))
    return way[: way.index(elbow_of(roles, side)) + 1][::-1]


def forearm(skeleton: Skeleton, roles: Roles, side: Side) -> Floats:
    """From elbow to wrist [3], metres, in the bind pose. Raises SkeletonError if both are in one place."""
    bone = np.asarray(skeleton.offsets[forearm_of(skeleton, roles, side)[1:]].sum(axis=0))
    if not np.any(bone):
        raise SkeletonError(f"the {side} forearm has no length", mend="Name the joints of the arm as roles")
    return bone


def ahead_of(bone: Floats) -> Floats:
    """A unit vector [3] square to a forearm [3], and as far ahead as can be: where the thumb's side of a wrist is in a
    bind pose. Of a forearm that points ahead itself it is above."""
    along = bone / np.linalg.norm(bone)
    ahead = np.array([0.0, 0.0, 1.0]) - along * along[2]
    size = float(np.linalg.norm(ahead))
    return ahead / size if size > STRAIGHT else np.array([0.0, 1.0, 0.0])


def fingers_of(skeleton: Skeleton, roles: Roles, side: Side) -> list[int]:
    """The joints that lead from a wrist to the tips of fingers, in order; none if it has fewer than three of them.

    Fingers are known by name; where nothing is named so, all that hangs on the wrist.
    """
    joints = _called(skeleton, wrist_of(roles, side)) or skeleton.subtree(wrist_of(roles, side))[1:]
    tips = set(joints) - {int(skeleton.parents[joint]) for joint in joints}
    return joints if len(tips) >= FEWEST_TIPS else []


def _called(skeleton: Skeleton, wrist: int) -> list[int]:
    """The joints between a wrist and those that are called fingers, in order."""
    below = skeleton.subtree(wrist)[1:]
    fingers = [joint for joint in below if HAND.search(side_and_part(skeleton.names[joint])[1])]
    ways = {one for joint in fingers for one in skeleton.chain(joint)}
    return [joint for joint in below if joint in ways]


def has_fingers(skeleton: Skeleton, roles: Roles) -> bool:
    """Whether either hand has fingers: those that have a thumb and a mitten at most have none."""
    return any(fingers_of(skeleton, roles, side) for side in SIDES)


def match_fingers(ours: Skeleton, our_roles: Roles, theirs: Skeleton, their_roles: Roles, side: Side) -> dict[int, int]:
    """For each joint of our hand the one of theirs: by the names of fingers, else by the order of like chains.

    Joints of ours that they lack (a metacarpal) are left out. Raises SkeletonError if nothing fits.
    """
    mine, other = fingers_of(ours, our_roles, side), fingers_of(theirs, their_roles, side)
    named = {name: joint for joint, name in _named(theirs, other).items()}
    match = {joint: named[name] for joint, name in _named(ours, mine).items() if name in named}
    if not match and _shape(ours, mine) == _shape(theirs, other):
        match = dict(zip(mine, other, strict=True))
    if mine and not other:
        mend = "Export the hands with their fingers, or take the other hand alone"
        raise SkeletonError(f"the hands' rig has no fingers on its {side} hand", mend=mend)
    if mine and not match:
        raise SkeletonError(
            f"the fingers of the {side} hand, {ours.names[mine[0]]!r} and so on, are not those of the hands' rig",
            mend="Name them thumb, index, middle, ring and pinky, with a number from the palm on",
        )
    return match


def _named(skeleton: Skeleton, joints: list[int]) -> dict[int, tuple[str, int]]:
    """Finger and place, from 1 at the palm on, of those joints whose names say so.

    By its number; where no joint of a finger has one, as they come. Bones within the palm are at 0.
    """
    found = {joint: FINGER.search(part) for joint in joints if (part := side_and_part(skeleton.names[joint])[1])}
    told = {joint: (SAME_FINGER.get(one[1], one[1]), one[2]) for joint, one in found.items() if one is not None}
    numbered = {finger for finger, number in told.values() if number}
    places: dict[int, tuple[str, int]] = {}
    for joint, (finger, number) in told.items():
        palm = finger in numbered or (finger != "thumb" and "metacarpal" in skeleton.names[joint].lower())
        before = sum(other == finger and place > 0 for other, place in places.values())
        places[joint] = finger, int(number) if number else 0 if palm else 1 + before
    return places


def _shape(skeleton: Skeleton, joints: list[int]) -> list[int]:
    """How joints hang on each other: the place of each one's parent among them."""
    return [joints.index(int(skeleton.parents[joint])) if skeleton.parents[joint] in joints else -1 for joint in joints]


def bind_turn(ours: Skeleton, our_roles: Roles, theirs: Skeleton, their_roles: Roles, side: Side) -> Floats:
    """The rotation [4] that lays their hand on ours as both are in their bind poses.

    By forearm and fingers; where we have no fingers, by the forearm alone.
    """
    arms = forearm(ours, our_roles, side), forearm(theirs, their_roles, side)
    bones = [arms]
    if fingers_of(ours, our_roles, side):
        match = match_fingers(ours, our_roles, theirs, their_roles, side)
        bones += [(ours.offsets[one], theirs.offsets[other]) for one, other in match.items()]
    else:
        bones.append((ahead_of(arms[0]), ahead_of(arms[1])))
    turn = horn_rotation([_unit(one) for one, _ in bones], [_unit(other) for _, other in bones])
    return turn if angle(turn, IDENTITY) > ALIKE else IDENTITY


def _unit(v: Floats) -> Floats:
    size = float(np.linalg.norm(v))
    return v / size if size > 0.0 else v


def graft_fingers(
    skeleton: Skeleton, roles: Roles, theirs: Skeleton, their_roles: Roles
) -> tuple[Skeleton, Roles, Integers]:
    """A rig without fingers with theirs, as large as its forearms are; the new roles; and where its joints are now [J].

    What it has of a mitten, at -1 then, gives way to them; what hangs on that is hung on what is above. Raises
    SkeletonError if they have no fingers either.
    """
    if not has_fingers(theirs, their_roles):
        raise SkeletonError("neither the body nor the hands have fingers", mend="Export the hands with their fingers")
    sides = {wrist_of(roles, side): side for side in SIDES}
    mittens = {joint for wrist in sides for joint in _called(skeleton, wrist)}
    taken = {name for joint, name in enumerate(skeleton.names) if joint not in mittens}
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
            names.append(name if name not in taken else f"{sides[joint]}:{name}")
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
    """A clip with fingers, straight ones of another rig's if it has none of its own, and its roles.

    Raises SkeletonError if neither has any.
    """
    if has_fingers(clip.skeleton, roles):
        return clip, roles
    skeleton, moved, places = graft_fingers(clip.skeleton, roles, theirs, their_roles)
    rotations = np.tile(IDENTITY, (clip.frame_count, skeleton.joint_count, 1))
    rotations[:, places[places >= 0]] = clip.rotations[:, places >= 0]
    return replace(clip, skeleton=skeleton, rotations=rotations), moved


def moved_roles(roles: Roles, places: Integers) -> Roles:
    """The roles of a rig whose joints are now at `places` [J]."""

    def place(joint: int) -> int:
        return int(places[joint]) if joint >= 0 else -1

    moved = {one.name: place(getattr(roles, one.name)) for one in fields(Roles) if one.name != "spine"}
    return replace(roles, **moved, spine=tuple(place(joint) for joint in roles.spine))
