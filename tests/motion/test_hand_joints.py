from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.hand_joints import (
    bind_turn,
    fingered,
    fingers_of,
    forearm,
    forearm_of,
    graft_fingers,
    has_fingers,
    match_fingers,
    wrist_of,
)
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.hand_rig import FINGERED, FINGERS
from motionsplice.motion.quaternion import about, rotate
from motionsplice.motion.roles import SIDES, find_roles
from motionsplice.motion.skeleton import Skeleton
from tests.conftest import CLIPS, COUNTING
from tests.rigs import with_arms_turned, with_bones_above

WALK = CLIPS["walk"].frames(0, 20)
BARE, BARE_ROLES = WALK.skeleton, find_roles(WALK.skeleton)
ROLES = find_roles(FINGERED)
STILL = Clip("still", FINGERED, 60.0, np.zeros((1, 3)), np.tile(quaternion.IDENTITY, (1, FINGERED.joint_count, 1)))
BONES = ("Proximal", "Intermediate", "Distal")


def rigify(side: str, finger: str, number: int) -> str:
    return f"DEF-{'' if finger == 'Thumb' else 'f_'}{finger.lower()}.{number:02}.{side[0]}"


def vrm_1(side: str, finger: str, number: int) -> str:
    bones = ("Metacarpal", "Proximal", "Distal") if finger == "Thumb" else BONES
    return f"{side.lower()}{'Little' if finger == 'Pinky' else finger}{bones[number - 1]}"


NAMES: Mapping[str, Callable[[str, str, int], str]] = {
    "built in": lambda side, finger, number: f"{side}Hand{finger}{number}",
    "Mixamo": lambda side, finger, number: f"mixamorig:{side}Hand{finger}{number}",
    "Unreal": lambda side, finger, number: f"{finger.lower()}_{number:02}_{side[0].lower()}",
    "Rigify": rigify,
    "Unity, VRM 0": lambda side, finger, number: f"{side}{finger.replace('Pinky', 'Little')}{BONES[number - 1]}",
    "VRM 1": vrm_1,
    "VRoid": lambda side, finger, number: f"J_Bip_{side[0]}_{finger.replace('Pinky', 'Little')}{number}",
    "SMPL-X": lambda side, finger, number: f"{side.lower()}_{finger.lower()}{number}",
}
OWN = re.compile(r"(Left|Right)Hand(\w+)(\d)")


def renamed(skeleton: Skeleton, name: Callable[[str, str, int], str]) -> Skeleton:
    """Returns the built-in rig with other names for its finger joints."""
    names = [
        name(found[1], found[2], int(found[3])) if (found := OWN.fullmatch(own)) else own for own in skeleton.names
    ]
    return replace(skeleton, names=tuple(names))


def with_metacarpals(skeleton: Skeleton, name: str) -> Skeleton:
    """Returns the rig with a bone in the palm for each finger except the thumb."""
    above = {
        f"{side}Hand{finger}1": name.format(side=side, s=side[0].lower(), finger=finger.lower())
        for side in ("Left", "Right")
        for finger in FINGERS[1:]
    }
    return with_bones_above(replace(STILL, skeleton=skeleton), above).skeleton


@pytest.mark.parametrize("ours", NAMES)
@pytest.mark.parametrize("theirs", NAMES)
def test_fingers_are_matched_by_the_names_of_common_rigs(ours: str, theirs: str) -> None:
    rigs = renamed(FINGERED, NAMES[ours]), renamed(FINGERED, NAMES[theirs])
    for side in SIDES:
        joints = fingers_of(FINGERED, ROLES, side)
        assert match_fingers(rigs[0], ROLES, rigs[1], ROLES, side) == dict(zip(joints, joints, strict=True))


@pytest.mark.parametrize(
    ("names", "palm"),
    [
        ("Unreal", "{finger}_metacarpal_{s}"),
        ("Mixamo", "{side}InHand{finger}"),
        ("Mixamo", "{side}Hand{finger}0"),
        ("VRM 1", "{side}{finger}Metacarpal"),
    ],
)
def test_metacarpals_are_left_out_unless_both_rigs_have_them(names: str, palm: str) -> None:
    rig = renamed(with_metacarpals(FINGERED, palm), NAMES[names])
    roles = find_roles(rig)
    for side in SIDES:
        joints, named = fingers_of(FINGERED, ROLES, side), fingers_of(rig, roles, side)
        assert len(named) == 19
        ours = match_fingers(rig, roles, FINGERED, ROLES, side)
        assert sorted(ours.values()) == joints
        renamed_joints = renamed(FINGERED, NAMES[names]).names
        assert [rig.names[joint] for joint in ours] == [renamed_joints[joint] for joint in ours.values()]
        assert match_fingers(FINGERED, ROLES, rig, roles, side) == {theirs: mine for mine, theirs in ours.items()}
        assert match_fingers(rig, roles, rig, roles, side) == dict(zip(named, named, strict=True))


def test_a_hand_with_fewer_fingers_or_bones_is_matched_in_part() -> None:
    left = [joint for joint, name in enumerate(FINGERED.names) if "Ring" not in name and not name.endswith("3")]
    less = replace(
        FINGERED,
        names=tuple(FINGERED.names[joint] for joint in left),
        parents=np.array([left.index(FINGERED.parents[joint]) if joint else -1 for joint in left]),
        offsets=FINGERED.offsets[left],
        end_parents=np.zeros(0, np.int64),
        end_offsets=np.zeros((0, 3)),
    )
    match = match_fingers(FINGERED, ROLES, less, find_roles(less), "left")
    assert len(match) == 8
    assert all(FINGERED.names[ours] == less.names[theirs] for ours, theirs in match.items())


def test_fingers_with_unknown_names_are_matched_by_order_if_the_trees_are_equal() -> None:
    digits = renamed(FINGERED, lambda side, finger, number: f"Bip01 {side[0]} Digit{FINGERS.index(finger)}{number}")
    joints = fingers_of(FINGERED, ROLES, "right")
    for rigs in ((digits, FINGERED), (FINGERED, digits)):
        assert match_fingers(rigs[0], ROLES, rigs[1], ROLES, "right") == dict(zip(joints, joints, strict=True))
    longer = with_bones_above(replace(STILL, skeleton=digits), {"Bip01 R Digit21": "Bip01 R Palm2"}).skeleton
    with pytest.raises(
        SkeletonError,
        match=r"no finger of the right hand \('Bip01 R Digit01' \.\.\.\) matches .* Name the fingers thumb, index",
    ):
        match_fingers(longer, find_roles(longer), FINGERED, ROLES, "right")


def test_hands_with_similar_bind_poses_need_no_rotation() -> None:
    for side in SIDES:
        small = with_arms_turned(FINGERED, 0.06)  # hands differ in shape
        for rig in (FINGERED, FINGERED.scaled(0.8), small):
            np.testing.assert_array_equal(bind_turn(FINGERED, ROLES, rig, ROLES, side), quaternion.IDENTITY)


@pytest.mark.parametrize("down", [-0.5, 0.3, 0.8, 1.4])
def test_fingers_point_along_the_hand_in_any_bind_pose(down: float) -> None:
    ours, bare = with_arms_turned(FINGERED, down), with_arms_turned(BARE, down)
    for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
        wanted = about([0.0, 0.0, 1.0], sign * down)
        for rig, roles in ((ours, ROLES), (bare, BARE_ROLES)):  # the second by its forearm only
            turn = bind_turn(rig, roles, FINGERED, ROLES, side)
            assert quaternion.angle(turn, wanted) < 1e-6
        joints = fingers_of(FINGERED, ROLES, side)
        np.testing.assert_allclose(rotate(turn, FINGERED.offsets[joints]), ours.offsets[joints], atol=1e-9)


def test_added_fingers_are_scaled_to_the_forearms() -> None:
    theirs = FINGERED.scaled(0.7)
    rig, roles, places = graft_fingers(BARE, BARE_ROLES, theirs, ROLES)
    assert set(rig.names) == set(FINGERED.names)
    for joint, place in enumerate(places):
        assert rig.names[place] == BARE.names[joint]
        assert np.array_equal(rig.offsets[place], BARE.offsets[joint])
        if joint:
            assert rig.parents[place] == places[BARE.parents[joint]]
    assert roles == find_roles(rig)
    for joint, name in enumerate(
        rig.names
    ):  # both rigs are the same body at two sizes, so the fingers are the original ones
        np.testing.assert_allclose(rig.offsets[joint], FINGERED.offsets[FINGERED.index(name)], atol=1e-12)
    ends = {rig.names[joint]: offset for joint, offset in zip(rig.end_parents, rig.end_offsets, strict=True)}
    for joint, offset in zip(FINGERED.end_parents, FINGERED.end_offsets, strict=True):
        np.testing.assert_allclose(ends.pop(FINGERED.names[joint]), offset, atol=1e-12)
    assert not ends


def test_a_forearm_includes_its_twist_bone() -> None:
    above = {"LeftHand": "LeftForeArmTwist", "RightHand": "RightForeArmTwist"}
    twisting = with_bones_above(WALK, above).skeleton
    roles = find_roles(twisting)
    assert [twisting.names[joint] for joint in forearm_of(twisting, roles, "left")] == [
        "LeftForeArm",
        "LeftForeArmTwist",
        "LeftHand",
    ]
    np.testing.assert_allclose(forearm(twisting, roles, "left"), forearm(BARE, BARE_ROLES, "left"))
    rig, _, _ = graft_fingers(twisting, roles, FINGERED, ROLES)
    for joint in fingers_of(FINGERED, ROLES, "left"):
        grafted = rig.offsets[rig.index(FINGERED.names[joint])]
        np.testing.assert_allclose(grafted, FINGERED.offsets[joint], atol=1e-12)


def test_added_fingers_follow_the_hand_in_another_bind_pose() -> None:
    rig, roles, _ = graft_fingers(with_arms_turned(BARE, 0.8), BARE_ROLES, FINGERED, ROLES)
    wanted = with_arms_turned(FINGERED, 0.8)
    for side in SIDES:
        for joint in fingers_of(rig, roles, side):
            np.testing.assert_allclose(rig.offsets[joint], wanted.offsets[wanted.index(rig.names[joint])], atol=1e-6)


def test_existing_joints_keep_names_that_clash_with_added_fingers() -> None:
    toe = BARE.names[BARE_ROLES.left_toe]
    odd = replace(BARE, names=tuple("RightHandThumb2" if name == toe else name for name in BARE.names))
    rig, roles, places = graft_fingers(odd, BARE_ROLES, FINGERED, ROLES)
    assert rig.names[places[BARE_ROLES.left_toe]] == "RightHandThumb2"
    match = match_fingers(rig, roles, FINGERED, ROLES, "right")
    assert [FINGERED.names[joint] for joint in match.values()][1] == "RightHandThumb2"


def test_adding_fingers_does_not_change_the_motion() -> None:
    clip, roles = fingered(WALK, BARE_ROLES, FINGERED, ROLES)
    before, after = joint_positions(WALK), joint_positions(clip)
    places = [clip.skeleton.index(name) for name in BARE.names]
    np.testing.assert_allclose(after[:, places], before, atol=1e-12)
    for side in SIDES:
        joints = fingers_of(clip.skeleton, roles, side)
        assert len(joints) == 15
        np.testing.assert_array_equal(clip.rotations[:, joints], np.tile(quaternion.IDENTITY, (20, 15, 1)))
    again = fingered(clip, roles, BARE, BARE_ROLES)
    assert again == (clip, roles)  # a clip with fingers is returned unchanged


def with_mittens(skeleton: Skeleton) -> Skeleton:
    """Returns a rig with mittens like CMU's: a joint for all fingers and a thumb; and with objects in its hands."""
    added = [
        (name.format(side), above.format(side), (sign * x, 0.0, z))
        for side, sign in (("Left", 1.0), ("Right", -1.0))
        for name, above, x, z in (
            ("{}FingerBase", "{}Hand", 0.0, 0.0),
            ("{}HandIndex1", "{}FingerBase", 0.04, 0.0),
            ("{}Thumb", "{}Hand", 0.0, 0.0),
            ("{}Prop", "{}Hand", 0.1, 0.0),
            ("{}Knife", "{}HandIndex1", 0.05, 0.02),
        )
    ]
    names = (*skeleton.names, *(name for name, _, _ in added))
    return replace(
        skeleton,
        names=names,
        parents=np.concatenate([skeleton.parents, [names.index(above) for _, above, _ in added]]),
        offsets=np.concatenate([skeleton.offsets, [offset for *_, offset in added]]),
    )


def test_fingers_replace_a_mitten_and_held_objects_stay() -> None:
    mittened = with_mittens(BARE)
    assert not has_fingers(mittened, BARE_ROLES)
    rig, roles, places = graft_fingers(mittened, BARE_ROLES, FINGERED, ROLES)
    removed = {mittened.names[joint] for joint in np.flatnonzero(places < 0)}
    assert removed == {f"{side}{part}" for side in ("Left", "Right") for part in ("FingerBase", "HandIndex1", "Thumb")}
    for side in SIDES:
        assert [rig.names[joint] for joint in fingers_of(rig, roles, side)] == [
            FINGERED.names[joint] for joint in fingers_of(FINGERED, ROLES, side)
        ]
    for held, x, z in (("Prop", 0.1, 0.0), ("Knife", 0.09, 0.02)):
        assert rig.parents[rig.index(f"Left{held}")] == rig.index("LeftHand")
        np.testing.assert_allclose(rig.offsets[rig.index(f"Left{held}")], [x, 0.0, z], atol=1e-12)
    rotations = np.tile(quaternion.IDENTITY, (WALK.frame_count, mittened.joint_count, 1))
    rotations[:, : BARE.joint_count] = WALK.rotations
    clip, _ = fingered(replace(WALK, skeleton=mittened, rotations=rotations), BARE_ROLES, FINGERED, ROLES)
    joints = [clip.skeleton.index(name) for name in BARE.names]
    np.testing.assert_allclose(joint_positions(clip)[:, joints], joint_positions(WALK), atol=1e-12)


def test_added_fingers_can_be_added_to_another_rig_unchanged() -> None:
    mittened = with_mittens(BARE)
    rig, roles, _ = graft_fingers(mittened, BARE_ROLES, FINGERED, ROLES)
    again, *_ = graft_fingers(mittened, BARE_ROLES, rig, roles)
    assert again.names == rig.names
    np.testing.assert_allclose(again.offsets, rig.offsets, atol=1e-12)


def test_two_rigs_without_fingers_are_refused() -> None:
    assert not has_fingers(BARE, BARE_ROLES)
    with pytest.raises(SkeletonError, match="neither the body nor the hands have fingers"):
        fingered(WALK, BARE_ROLES, BARE, BARE_ROLES)


def test_a_clip_with_fingers_survives_writing_and_reading(tmp_path: Path) -> None:
    truth = COUNTING.truth.frames(100, 140)
    file = tmp_path / "truth.bvh"
    file.write_bytes(dump_bvh(truth))
    reading = read_clip(file)
    rig = reading.clip.skeleton
    assert rig.names == FINGERED.names
    assert reading.roles == ROLES
    assert len(rig.end_parents) == len(FINGERED.end_parents)
    for side in SIDES:
        joints = fingers_of(FINGERED, ROLES, side)
        assert rig.parents[joints[0]] == wrist_of(reading.roles, side)
        assert match_fingers(rig, reading.roles, FINGERED, ROLES, side) == dict(zip(joints, joints, strict=True))
        assert np.ptp(truth.rotations[:, joints], axis=0).max() > 0.3
    assert quaternion.angle(reading.clip.rotations, truth.rotations).max() < 1e-4
