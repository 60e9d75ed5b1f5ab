from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.retarget.kinds import KINDS
from bench.retarget.rigs import on_rig
from motionsplice.motion import quaternion
from motionsplice.motion.body_shape import check_shape, standing_axis
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import RoleError, SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.formats.reading import Reading, read_clip
from motionsplice.motion.formats.upright import TURNS, turned
from motionsplice.motion.kinematics import bind_positions, joint_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from tests.conftest import CLIPS
from tests.rigs import leaning, z_up

WALK = CLIPS["walk"].frames(0, 90)
ROLES = find_roles(WALK.skeleton)


def read(folder: Path, clip: Clip, suffix: str = ".bvh", up: str | None = None) -> Reading:
    path = folder / f"clip{suffix}"
    path.write_bytes(dump_glb(clip) if suffix == ".glb" else dump_bvh(clip))
    return read_clip(path, unit="m", up=up)


def same_motion(found: Clip, expected: Clip) -> None:
    """Checks world positions and the bind pose; joints may come in another order."""
    order = [found.skeleton.index(name) for name in expected.skeleton.names]
    np.testing.assert_allclose(joint_positions(found)[:, order], joint_positions(expected), atol=1e-4)
    np.testing.assert_allclose(bind_positions(found.skeleton)[order], bind_positions(expected.skeleton), atol=1e-4)


@pytest.mark.parametrize("name", ["walk", "stairs_up", "side_step", "carry_box"])
def test_a_file_in_which_z_is_up_is_read_as_if_y_were(tmp_path: Path, name: str) -> None:
    clip = CLIPS[name].frames(0, 60)
    reading = read(tmp_path, z_up(clip))
    same_motion(reading.clip, clip)
    assert reading.notes == ("Z is up in the file: turned to Y up. If it is not, give --up y",)
    assert not reading.warnings


def test_a_file_in_which_x_is_up_is_read_as_if_y_were(tmp_path: Path) -> None:
    on_its_side = quaternion.about([0.0, 0.0, 1.0], -0.5 * np.pi)  # Y to X
    reading = read(tmp_path, turned(WALK, on_its_side, on_its_side))
    same_motion(reading.clip, WALK)
    assert "X is up in the file" in reading.notes[0]


@pytest.mark.parametrize("up", ["-x", "-y", "-z"])
@pytest.mark.parametrize("told", [False, True])
def test_a_file_in_which_an_axis_points_down_is_turned_too(tmp_path: Path, up: str, told: bool) -> None:
    over = quaternion.conjugate(TURNS[up])
    reading = read(tmp_path, turned(WALK, over, over), up=up if told else None)
    same_motion(reading.clip, WALK)
    assert reading.notes == (
        () if told else (f"{up.upper()} is up in the file: turned to Y up. If it is not, give --up y",)
    )
    assert not reading.warnings


def test_a_motion_of_a_camera_with_y_down_is_read_as_told(tmp_path: Path) -> None:
    clip = turned(WALK, quaternion.IDENTITY, quaternion.about([1.0, 0.0, 0.0], np.pi))
    assert "If -Y is up in the file, give --up -y" in read(tmp_path, clip).warnings[0]
    same_motion(read(tmp_path, clip, up="-y").clip, WALK)


def test_a_leaning_body_in_a_file_in_which_z_is_up_is_turned_too(tmp_path: Path) -> None:
    same_motion(read(tmp_path, z_up(leaning(WALK, 0.6))).clip, leaning(WALK, 0.6))


@pytest.mark.parametrize("suffix", [".bvh", ".glb"])
@pytest.mark.parametrize("angle", [-0.5 * np.pi, -1.4, 1.4, 0.5 * np.pi])
def test_a_body_that_lies_is_not_turned_but_warned_about(tmp_path: Path, suffix: str, angle: float) -> None:
    clip = leaning(WALK, angle)
    reading = read(tmp_path, clip, suffix)
    same_motion(reading.clip, clip)
    (warning,) = reading.warnings
    assert warning.startswith("the body is not upright in most frames: ")
    assert ("If Z is up in the file, give --up z" in warning) == (angle > 0.0)


def test_a_motion_in_which_z_is_up_over_a_bind_pose_that_stands_along_y_is_read_as_told(tmp_path: Path) -> None:
    """Motions of SMPL are like that."""
    clip = turned(WALK, quaternion.IDENTITY, quaternion.about([1.0, 0.0, 0.0], 0.5 * np.pi))
    untold = read(tmp_path, clip)
    same_motion(untold.clip, clip)
    assert "If Z is up in the file, give --up z" in untold.warnings[0]
    told = read(tmp_path, clip, up="z")
    same_motion(told.clip, WALK)
    assert not told.warnings
    assert not told.notes


@pytest.mark.parametrize("suffix", [".bvh", ".glb"])
def test_a_bind_pose_that_lies_is_turned_alone_if_the_motion_stands(tmp_path: Path, suffix: str) -> None:
    clip = turned(WALK, quaternion.about([1.0, 0.0, 0.0], 0.5 * np.pi), quaternion.IDENTITY)
    reading = read(tmp_path, clip, suffix)
    same_motion(reading.clip, WALK)
    if suffix == ".glb":  # in which Y is up by definition
        assert (reading.notes, reading.warnings) == (("the bind pose stands along Z: turned to stand along Y",), ())
    else:
        assert reading.notes == ()
        assert reading.warnings[0].endswith("so Y is taken to be up. If Z is up in the file, give --up z")


def test_the_axis_that_is_given_is_up(tmp_path: Path) -> None:
    as_it_is = read(tmp_path, z_up(WALK), up="y")
    np.testing.assert_allclose(as_it_is.clip.root_positions, z_up(WALK).root_positions, atol=1e-5)
    (warning,) = as_it_is.warnings
    assert warning.startswith("the body is not upright in most frames")
    assert "--up" not in warning
    assert read(tmp_path, WALK, up="y").notes == ()
    with pytest.raises(SettingsError, match=r"'Z' is not an axis that can be up\. Use x, y, z"):
        read(tmp_path, WALK, up="Z")


@given(st.integers(0, 2**32 - 1))
def test_a_turned_clip_moves_and_stands_as_before_but_turned(seed: int) -> None:
    random = np.random.default_rng(seed)
    bind, world = quaternion.normalise(random.normal(size=(2, 4)))
    clip = WALK.frames(0, 3)
    found = turned(clip, bind, world)
    np.testing.assert_allclose(joint_positions(found), quaternion.rotate(world, joint_positions(clip)), atol=1e-12)
    expected = quaternion.rotate(bind, bind_positions(clip.skeleton))
    np.testing.assert_allclose(bind_positions(found.skeleton), expected, atol=1e-12)
    back = turned(found, quaternion.conjugate(bind), quaternion.conjugate(world))
    assert quaternion.angle(back.rotations, clip.rotations).max() < 1e-6


@given(st.integers(0, 2**32 - 1), st.sampled_from("xyz"), st.floats(0.0, 0.5))
def test_a_body_stands_along_the_axis_nearest_to_its_trunk(seed: int, axis: str, tilt: float) -> None:
    """Whichever way it faces, and if it leans by less than half a radian."""
    random = np.random.default_rng(seed)
    up = np.eye(3)["xyz".index(axis)]
    level = np.cross(up, random.normal(size=3))
    to_axis: Floats = {
        "x": quaternion.about([0.0, 0.0, 1.0], -0.5 * np.pi),
        "y": quaternion.IDENTITY,
        "z": quaternion.about([1.0, 0.0, 0.0], 0.5 * np.pi),
    }[axis]
    leaning = quaternion.about(level / np.linalg.norm(level), tilt)
    facing = quaternion.about(up, random.uniform(-np.pi, np.pi))
    turn = quaternion.multiply(leaning, quaternion.multiply(facing, to_axis))
    assert standing_axis(quaternion.rotate(turn, bind_positions(WALK.skeleton)[None]), ROLES) == axis


def test_a_body_half_way_between_two_axes_stands_along_none() -> None:
    turn = quaternion.about([1.0, 0.0, 0.0], 0.25 * np.pi)
    assert standing_axis(quaternion.rotate(turn, bind_positions(WALK.skeleton)[None]), ROLES) == ""


def test_roles_that_fit_neither_bind_pose_nor_motion_are_refused_unless_they_were_given() -> None:
    arms = {"shoulder": "Arm", "elbow": "ForeArm", "wrist": "Hand"}
    crossed = {f"left_{role}": f"Right{name}" for role, name in arms.items()}
    crossed |= {f"right_{role}": f"Left{name}" for role, name in arms.items()}
    roles = find_roles(WALK.skeleton, crossed)
    with pytest.raises(RoleError, match="neither in the bind pose nor in the motion: left and right are crossed"):
        check_shape(WALK, roles, given=False)
    (warning,) = check_shape(WALK, roles, given=True)
    assert warning.endswith(
        "crossed between hips and shoulders. Check left and right in the roles file, or in the humanoid of a VRM file"
    )
    assert check_shape(WALK, ROLES, given=False) == []


def test_a_body_on_its_head_is_refused_with_all_that_may_help() -> None:
    over = quaternion.about([0.0, 0.0, 1.0], np.pi)
    with pytest.raises(RoleError, match=r"knee is above .* give --up -y\. If not, name the joints in a file"):
        check_shape(turned(WALK, over, over), ROLES, given=False)


@pytest.mark.parametrize("angle", [1.5, 2.35])
def test_a_bind_pose_along_one_axis_does_not_contradict_a_body_that_lies(tmp_path: Path, angle: float) -> None:
    """As LAFAN1's, in which people crawl and lie on the ground."""
    clip = leaning(on_rig(WALK, KINDS["LAFAN1"]), angle)
    if angle == 1.5:  # or Z is up
        with pytest.raises(RoleError, match=r"unclear which axis is up: .* along Z, .* give --up z\. .* give --up y"):
            read(tmp_path, clip)
    reading = read(tmp_path, clip, up="y" if angle == 1.5 else None)
    same_motion(reading.clip, clip)
    assert reading.warnings[0].startswith("the body is not upright in most frames")


def on_all_fours(clip: Clip) -> Clip:
    """Returns a clip whose bind pose has the trunk level, and arms as long as the legs that point down."""
    offsets = clip.skeleton.offsets.copy()
    for joint, parent in enumerate(clip.skeleton.parents.tolist()):
        name = clip.skeleton.names[joint]
        if joint and ("Spine" in name or name in ("Neck", "Head")):
            offsets[joint] = np.linalg.norm(offsets[joint]) * np.array([0.0, 0.0, 1.0])
        if name.endswith(("ForeArm", "Hand")) and parent:
            offsets[joint] = [0.0, -0.4, 0.0]
    return replace(clip, skeleton=replace(clip.skeleton, offsets=offsets))


@pytest.mark.parametrize("axes", ["y", "z"])
def test_a_body_that_stands_on_all_fours_at_rest_is_no_human(tmp_path: Path, axes: str) -> None:
    clip = on_all_fours(WALK)
    with pytest.raises(RoleError, match="not a human body: in the bind pose it stands on all fours"):
        read(tmp_path, clip if axes == "y" else z_up(clip))


def test_a_body_that_lies_in_a_file_in_which_z_is_up_is_turned_without_a_question(tmp_path: Path) -> None:
    clip = leaning(WALK, 1.4)
    reading = read(tmp_path, z_up(clip))
    same_motion(reading.clip, clip)
    (warning,) = reading.warnings
    assert "--up" not in warning
