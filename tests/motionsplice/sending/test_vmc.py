from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pythonosc.osc_bundle import OscBundle

from bench.retarget.kinds import KINDS
from bench.retarget.rigs import on_rig
from motionsplice.motion import quaternion
from motionsplice.motion.axes import AXES
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import bind_positions, joint_positions, local_rotations, world_transforms
from motionsplice.motion.procedural.hand_rig import with_fingers
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.sending.vmc import MOST, Vmc

WALK = make("walk", "wave", seconds=2.0)


def with_arms_on_the_neck(clip: Clip) -> Clip:
    """Returns a clip on a T-posed rig whose collar bones are children of the neck, as in 3ds Max Biped."""
    rig, binds = clip.skeleton, bind_positions(clip.skeleton)
    parents = rig.parents.copy()
    parents[[rig.index("LeftShoulder"), rig.index("RightShoulder")]] = rig.index("Neck")
    offsets = binds - binds[parents]
    offsets[0] = rig.offsets[0]
    skeleton = Skeleton(rig.names, parents, offsets, rig.end_parents, rig.end_offsets)
    _, world = world_transforms(rig, clip.root_positions, clip.rotations)
    nodding = quaternion.about(np.array([1.0, 0.0, 0.0]), np.linspace(0.2, 0.5, clip.frame_count))
    world[:, rig.index("Neck")] = quaternion.multiply(world[:, rig.index("Neck")], nodding)
    return Clip(clip.name, skeleton, clip.rate, clip.root_positions, local_rotations(skeleton, world))


RIGS = {name: on_rig(WALK, kind) for name, kind in KINDS.items()} | {"Biped": with_arms_on_the_neck(WALK)}
UNITY = AXES["unity"]
LIMBS = {  # Unity's bone and the one below, our roles of both, and where the bone points in the T-pose
    f"{side}{upper}": (f"{side}{lower}", f"{side.lower()}_{role}", f"{side.lower()}_{below}", aim)
    for side, out in (("Left", 1.0), ("Right", -1.0))
    for upper, lower, role, below, aim in (
        ("UpperLeg", "LowerLeg", "hip", "knee", [0.0, -1.0, 0.0]),
        ("LowerLeg", "Foot", "knee", "ankle", [0.0, -1.0, 0.0]),
        ("UpperArm", "LowerArm", "shoulder", "elbow", [out, 0.0, 0.0]),
        ("LowerArm", "Hand", "elbow", "wrist", [out, 0.0, 0.0]),
    )
}
PARENTS = {"Hips": "", "Spine": "Hips", "Chest": "Spine", "UpperChest": "Chest", "Neck": "UpperChest", "Head": "Neck"}
for side in ("Left", "Right"):
    chains = [["Hips", "UpperLeg", "LowerLeg", "Foot", "Toes"]]
    chains += [["UpperChest", "Shoulder", "UpperArm", "LowerArm", "Hand"]]
    for finger in ("Thumb", "Index", "Middle", "Ring", "Little"):
        chains += [["Hand", *(f"{finger}{part}" for part in ("Proximal", "Intermediate", "Distal"))]]
    for top, *below in chains:
        names = [side + top if top == "Hand" else top, *(side + name for name in below)]
        PARENTS |= dict(zip(names[1:], names, strict=False))


def messages(vmc: Vmc, clip: Clip, frame: int) -> list[tuple[str, list[Any]]]:
    datagrams = vmc.datagrams(frame / clip.rate, clip.root_positions[frame], clip.rotations[frame])
    return [(one.address, one.params) for datagram in datagrams for one in OscBundle(bytes(datagram))]


def received(found: list[tuple[str, list[Any]]]) -> dict[str, tuple[Floats, Floats]]:
    """Returns world positions [3] and rotations [4] of bones, in Unity's axes, as a receiver computes them.

    Bones that were not sent do not turn and lie where the bone above is.
    """
    local = {str(name): np.array(numbers) for address, (name, *numbers) in found if "Bone" in address}
    world: dict[str, tuple[Floats, Floats]] = {"": (np.zeros(3), quaternion.IDENTITY)}
    for bone, parent in PARENTS.items():
        at, turn = world[parent]
        numbers = local.pop(bone, np.array([0.0, 0.0, 0.0, *quaternion.IDENTITY]))
        world[bone] = at + quaternion.rotate(turn, numbers[:3]), quaternion.multiply(turn, numbers[3:])
    assert not local  # no bone has a name that Unity does not have
    return world


@pytest.mark.parametrize("name", RIGS)
def test_limbs_of_a_t_pose_skeleton_point_as_in_the_clip(name: str) -> None:
    """T-pose, A-pose, a body that faces back, bones along X, twist bones, 3 to 5 spine joints, arms on the neck."""
    clip = RIGS[name]
    roles, vmc, places = find_roles(clip.skeleton), Vmc(clip, find_roles(clip.skeleton)), joint_positions(clip)
    for frame in range(0, clip.frame_count, 10):
        world = received(messages(vmc, clip, frame))
        for bone, (lower, role, below, aim) in LIMBS.items():
            expected = places[frame, getattr(roles, below)] - places[frame, getattr(roles, role)]
            (at, turn), (end, _) = world[bone], world[lower]
            pointed = UNITY.positions(quaternion.rotate(turn, UNITY.positions(np.array(aim))))  # its own inverse
            cosine = pointed @ expected / np.linalg.norm(expected)
            assert np.degrees(np.arccos(min(cosine, 1.0))) < 0.1, bone
            np.testing.assert_allclose(UNITY.positions(end - at), expected, atol=1e-5)


@pytest.mark.parametrize("name", RIGS)
def test_bones_lie_where_the_joints_of_the_clip_lie(name: str) -> None:
    """Unlike directions alone, this finds a wrong position of a bone below joints that have no bone."""
    clip = RIGS[name]
    roles, vmc, places = find_roles(clip.skeleton), Vmc(clip, find_roles(clip.skeleton)), joint_positions(clip)
    joints = {"Hips": roles.root, "Head": roles.head, "LeftToes": roles.left_toe, "RightHand": roles.right_wrist}
    for frame in (0, 37):
        world = received(messages(vmc, clip, frame))
        for bone, joint in joints.items():
            np.testing.assert_allclose(UNITY.positions(world[bone][0]), places[frame, joint], atol=1e-5, err_msg=bone)


def test_a_frame_has_the_messages_of_the_protocol() -> None:
    vmc = Vmc(WALK, find_roles(WALK.skeleton))
    (root, *bones, available, time) = messages(vmc, WALK, 30)
    assert root == ("/VMC/Ext/Root/Pos", ["root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    assert {address for address, _ in bones} == {"/VMC/Ext/Bone/Pos"}
    assert [values[0] for _, values in bones] == vmc.bones
    assert (available, time) == (("/VMC/Ext/OK", [1]), ("/VMC/Ext/T", [0.5]))
    assert vmc.bones[0] == "Hips"
    assert {"Spine", "Chest", "UpperChest", "Neck", "Head", "LeftUpperLeg", "RightShoulder", "RightToes"} <= set(
        vmc.bones
    )


def test_a_bone_has_the_numbers_of_the_pose() -> None:
    """The built-in rig is bound in a T-pose, so that a bone's rotation is its joint's, in Unity's axes."""
    vmc, clip = Vmc(WALK, find_roles(WALK.skeleton)), WALK
    found = {values[0]: np.array(values[1:]) for address, values in messages(vmc, clip, 12) if "Bone" in address}
    joint = clip.skeleton.index("LeftLeg")
    x, y, z, w = clip.rotations[12, joint].astype(np.float32)
    a, b, c = clip.skeleton.offsets[joint].astype(np.float32)
    np.testing.assert_allclose(found["LeftLowerLeg"], [-a, b, c, x, -y, -z, w], atol=1e-7)


@pytest.mark.parametrize(("clip", "joints"), [(WALK, 22), (with_fingers(WALK), 52)])
def test_datagrams_pass_ethernet_whole(clip: Clip, joints: int) -> None:
    vmc = Vmc(clip, find_roles(clip.skeleton))
    sizes = [len(one) for one in vmc.datagrams(0.0, clip.root_positions[0], clip.rotations[0])]
    assert len(vmc.bones) == joints == clip.skeleton.joint_count
    assert max(sizes) <= MOST < 1472
    assert len(sizes) == -(-sum(sizes) // MOST)  # no more than needed


def test_no_bone_but_the_roots_lies_where_the_bone_above_lies() -> None:
    """Godot's tracker places joints by these positions, so zeros would make the body a point."""
    vmc = Vmc(with_fingers(WALK), find_roles(with_fingers(WALK).skeleton))
    for address, (_, *numbers) in messages(vmc, with_fingers(WALK), 0):
        assert address != "/VMC/Ext/Bone/Pos" or np.linalg.norm(numbers[:3]) > 0.005


def test_fingers_have_unitys_names() -> None:
    clip = with_fingers(WALK)
    vmc = Vmc(clip, find_roles(clip.skeleton))
    assert set(vmc.bones) == set(PARENTS)
    order = [vmc.bones.index(f"LeftThumb{part}") for part in ("Proximal", "Intermediate", "Distal")]
    assert order == sorted(order)


def test_a_rig_without_head_is_sent_too() -> None:
    skeleton = WALK.skeleton
    names = tuple(name.replace("Head", "Top") for name in skeleton.names)
    headless = Skeleton(names, skeleton.parents, skeleton.offsets, skeleton.end_parents, skeleton.end_offsets)
    clip = Clip("walk", headless, WALK.rate, WALK.root_positions, WALK.rotations)
    assert "Head" not in Vmc(clip, find_roles(headless)).bones


def test_no_bone_is_sent_twice() -> None:
    """A known rig calls the left little finger LeftHandRingPinky; a copied joint repeats a finger's name."""
    clip = with_fingers(WALK)
    names = [name.replace("LeftHandPinky", "LeftHandRingPinky") for name in clip.skeleton.names]
    names[names.index("RightHandPinky3")] = "RightHandPinky2_end"
    rig = clip.skeleton
    skeleton = Skeleton(tuple(names), rig.parents, rig.offsets, rig.end_parents, rig.end_offsets)
    bones = Vmc(replace(clip, skeleton=skeleton), find_roles(skeleton)).bones
    assert len(set(bones)) == len(bones)
    assert set(PARENTS) - set(bones) == {"RightLittleDistal"}
