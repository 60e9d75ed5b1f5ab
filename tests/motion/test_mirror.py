from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.retarget.kinds import KINDS
from bench.retarget.rigs import on_rig
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.procedural.library import make
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import find_roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.motion.twins import MIRROR
from tests.rigs import with_bones_above

WALK = make("curve", "wave", seconds=2.0)


def mirror_of(clip: Clip) -> Mirror:
    roles = find_roles(clip.skeleton)
    return Mirror.of(clip.skeleton, roles, standing_pose(clip.skeleton, roles, clip))


@pytest.mark.parametrize("kind", KINDS)
def test_joints_are_where_their_twins_are_in_a_mirror(kind: str) -> None:
    clip = on_rig(WALK, KINDS[kind])
    mirror = mirror_of(clip)
    assert np.all(mirror.twins[mirror.twins] == np.arange(len(mirror.twins)))
    expected = joint_positions(clip)[:, mirror.twins] * MIRROR
    # the palms of this Unreal rig are bound with the same roll left and right, so its hands are not symmetric
    away = 0.004 if kind == "Unreal" else 1e-9
    np.testing.assert_allclose(joint_positions(mirror.clip(clip)), expected, atol=away)


@pytest.mark.parametrize("kind", KINDS)
def test_mirrored_twice_is_the_clip(kind: str) -> None:
    clip = on_rig(WALK, KINDS[kind])
    mirror = mirror_of(clip)
    twice = mirror.clip(mirror.clip(clip))
    assert quaternion.angle(twice.rotations, clip.rotations).max() < 1e-12
    np.testing.assert_array_equal(twice.root_positions, clip.root_positions)


@pytest.mark.parametrize("kind", sorted(KINDS.keys() - {"Unreal"}))
def test_the_mirror_image_does_not_depend_on_the_axes_of_joints(kind: str) -> None:
    before, after = on_rig(mirror_of(WALK).clip(WALK), KINDS[kind]), on_rig(WALK, KINDS[kind])
    after = mirror_of(after).clip(after)
    np.testing.assert_allclose(joint_positions(before), joint_positions(after), atol=1e-9)
    assert quaternion.angle(before.rotations, after.rotations).max() < 1e-6


def with_joint(clip: Clip, name: str, parent: str) -> Clip:
    """Returns the clip with another joint at the end, which turns with time."""
    rig = clip.skeleton
    skeleton = Skeleton(
        (*rig.names, name),
        np.append(rig.parents, rig.index(parent)),
        np.concatenate([rig.offsets, [[0.13, -0.02, 0.1]]]),
        rig.end_parents,
        rig.end_offsets,
    )
    turns = quaternion.about([0.6, 0.8, 0.0], np.linspace(0.0, 2.0, clip.frame_count))
    return replace(clip, skeleton=skeleton, rotations=np.concatenate([clip.rotations, turns[:, None]], axis=1))


def test_a_weapon_keeps_its_rotation_on_the_hand_that_holds_it() -> None:
    clip = with_joint(WALK, "sword", "RightHand")
    mirror = mirror_of(clip)
    image = mirror.clip(clip)
    assert mirror.twins[-1] == -1
    np.testing.assert_array_equal(image.rotations[:, -1], clip.rotations[:, -1])
    expected = joint_positions(clip)[:, mirror.twins[:-1]] * MIRROR
    np.testing.assert_allclose(joint_positions(image)[:, :-1], expected, atol=1e-9)


def test_twins_are_found_by_place_where_names_do_not_show_them() -> None:
    clip = with_joint(WALK, "pocket", "Hips")
    offsets, parents = clip.skeleton.offsets * 1.0, clip.skeleton.parents
    other = Skeleton(
        (*clip.skeleton.names, "holster"),
        np.append(parents, 0),
        np.concatenate([offsets, offsets[-1:] * MIRROR]),
        clip.skeleton.end_parents,
        clip.skeleton.end_offsets,
    )
    both = replace(clip, skeleton=other, rotations=np.concatenate([clip.rotations, clip.rotations[:, -1:]], axis=1))
    assert mirror_of(both).twins[-2:].tolist() == [len(parents), len(parents) - 1]
    assert mirror_of(clip).twins[-1] == -1  # alone, it hangs at one side


def test_a_rig_with_a_limb_of_other_joints_on_one_side_is_refused() -> None:
    clip = with_bones_above(WALK, {"LeftLeg": "extra"})
    with pytest.raises(SkeletonError, match=r"cannot be mirrored.*LeftLeg.*RightLeg"):
        mirror_of(clip)


def test_a_clip_is_read_mirrored(tmp_path: Path) -> None:
    file = tmp_path / "wave.bvh"
    file.write_bytes(dump_bvh(WALK, unit=0.01))
    plain, image = (joint_positions(read_clip(file, unit="cm", mirror=mirror).clip) for mirror in (False, True))
    np.testing.assert_allclose(image, plain[:, mirror_of(WALK).twins] * MIRROR, atol=1e-9)


def test_captured_limbs_are_mirrored_to_within_the_asymmetry_of_their_rig(real_motion: Path) -> None:
    reading = read_clip(real_motion / "06_02.bvh")
    clip, roles = reading.clip, reading.roles
    mirror = Mirror.of(clip.skeleton, roles, standing_pose(clip.skeleton, roles, clip))
    away = joint_positions(mirror.clip(clip)) - joint_positions(clip)[:, mirror.twins] * MIRROR
    joints = [roles.left_ankle, roles.right_ankle, roles.left_wrist, roles.right_wrist]
    assert np.linalg.norm(away[:, joints], axis=-1).max() < 0.05
