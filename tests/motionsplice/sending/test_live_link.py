from __future__ import annotations

import json

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.axes import AXES
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.hand_rig import with_fingers
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from motionsplice.sending.live_link import LiveLink


def world_positions(bones: list[dict[str, object]]) -> Floats:
    """Returns the world positions [J, 3] that an engine computes from local transforms."""
    positions, turns = np.zeros((len(bones), 3)), np.tile(quaternion.IDENTITY, (len(bones), 1))
    for joint, bone in enumerate(bones):
        location, rotation, parent = np.array(bone["Location"]), np.array(bone["Rotation"]), int(str(bone["Parent"]))
        if parent < 0:
            positions[joint], turns[joint] = location, rotation
            continue
        positions[joint] = positions[parent] + quaternion.rotate(turns[parent], location)
        turns[joint] = quaternion.multiply(turns[parent], rotation)
    return positions


def test_local_transforms_give_the_evaluators_world_positions(bank: Bank) -> None:
    """To the rounding of its float32 kinematics; those in float64 agree to 1e-4 cm."""
    evaluator, unreal = Evaluator(bank), AXES["unreal"]
    poses = evaluator.sequence(Splice("run", "wave"), np.linspace(0.0, 2.0, 40))
    expected = np.empty((40, bank.skeleton.joint_count, 3), np.float32)
    evaluator.world_positions(poses, expected)
    exact, _ = world_transforms(bank.skeleton, poses.root_positions, poses.rotations)
    link = LiveLink(bank.skeleton)
    for frame in range(40):
        (datagram,) = link.datagrams(0.0, poses.root_positions[frame], poses.rotations[frame])
        found = world_positions(json.loads(datagram)["motionsplice"])
        np.testing.assert_allclose(found, unreal.positions(exact[frame]), rtol=0.0, atol=1e-4)
        np.testing.assert_allclose(found, unreal.positions(expected[frame].astype(np.float64)), rtol=0.0, atol=5e-4)


def test_a_bone_has_the_fields_of_the_plugin(bank: Bank) -> None:
    pose = Evaluator(bank).pose(Splice("walk"), 0.5)
    (datagram,) = LiveLink(bank.skeleton).datagrams(0.0, pose.root_positions[0], pose.rotations[0])
    (subject,) = json.loads(datagram).values()
    assert [bone["Name"] for bone in subject] == list(bank.skeleton.names)
    assert [bone["Parent"] for bone in subject] == bank.skeleton.parents.tolist()
    assert {tuple(bone) for bone in subject} == {("Name", "Parent", "Location", "Scale", "Rotation")}
    assert {(len(bone["Location"]), len(bone["Rotation"])) for bone in subject} == {(3, 4)}
    assert {tuple(bone["Scale"]) for bone in subject} == {(1, 1, 1)}


def test_the_rotation_is_turned_with_the_axes(bank: Bank) -> None:
    """By the rule that the service uses too."""
    pose = Evaluator(bank).pose(Splice("walk"), 0.5)
    (datagram,) = LiveLink(bank.skeleton).datagrams(0.0, pose.root_positions[0], pose.rotations[0])
    found = [bone["Rotation"] for bone in json.loads(datagram)["motionsplice"]]
    axes = AXES["unreal"]
    expected = pose.rotations[0][:, [*axes.order, 3]] * np.array([*axes.turns, 1])
    np.testing.assert_allclose(found, expected, atol=1e-7)


def test_other_letters_are_escaped() -> None:
    """The plugin reads each byte as a character, which breaks UTF-8."""
    walk = make("walk", seconds=1.0)
    names = tuple(name.replace("Head", '頭"') for name in walk.skeleton.names)
    rig = Skeleton(names, walk.skeleton.parents, walk.skeleton.offsets, walk.skeleton.end_parents,
                   walk.skeleton.end_offsets)  # fmt: skip
    (datagram,) = LiveLink(rig).datagrams(0.0, walk.root_positions[0], walk.rotations[0])
    assert datagram.isascii()
    assert '頭"' in [bone["Name"] for bone in json.loads(datagram)["motionsplice"]]


def test_a_frame_of_a_hand_rig_fits_into_a_datagram() -> None:
    clip = with_fingers(make("walk", seconds=1.0))
    (datagram,) = LiveLink(clip.skeleton).datagrams(0.0, clip.root_positions[0], clip.rotations[0])
    assert 5_000 < len(datagram) < 9_216  # what macOS sends, unless it is set up otherwise


def test_a_rig_with_too_many_joints_is_refused() -> None:
    count = 700
    rig = Skeleton(
        tuple(f"joint{number}" for number in range(count)),
        np.arange(-1, count - 1),
        np.full((count, 3), 0.1),
        np.zeros(0, np.int64),
        np.zeros((0, 3)),
    )
    still = np.tile(quaternion.IDENTITY, (count, 1))
    with pytest.raises(SkeletonError, match="700 joints take"):
        LiveLink(rig).datagrams(0.0, np.zeros(3), still)
