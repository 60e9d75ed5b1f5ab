from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError, RoleError, SettingsError
from motionsplice.motion.formats import bvh
from motionsplice.motion.formats.files import clip_files, other_files, read_bytes
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.formats.units import GUESSED, UNITS, check_stated_unit, guess_unit, metres_per_unit
from motionsplice.motion.kinematics import joint_positions
from tests.conftest import CLIPS
from tests.rigs import two_bodies

WALK = CLIPS["walk"].frames(0, 30)


def written(folder: Path, clip: Clip = WALK, unit: float = 1.0) -> Path:
    path = folder / "walk.bvh"
    path.write_bytes(bvh.dump_bvh(clip, unit))
    return path


@pytest.mark.parametrize("unit", GUESSED)
def test_the_unit_is_guessed_from_the_legs_and_noted(tmp_path: Path, unit: str) -> None:
    reading = read_clip(written(tmp_path, unit=UNITS[unit]))
    assert reading.unit == UNITS[unit]
    assert f"assumed unit {unit} " in reading.notes[0]
    np.testing.assert_allclose(reading.clip.root_positions, WALK.root_positions, atol=1e-4)


def test_a_given_unit_is_used(tmp_path: Path) -> None:
    reading = read_clip(written(tmp_path), unit="2.5")
    np.testing.assert_allclose(reading.clip.root_positions, 2.5 * WALK.root_positions, atol=1e-4)
    assert not reading.notes
    for wrong in ("furlong", "0", "-1", "nan"):
        with pytest.raises(SettingsError, match="not a unit of length"):
            metres_per_unit(wrong)
    with pytest.raises(MotionError, match="legs have no length"):
        guess_unit(0.0)


@pytest.mark.parametrize(
    ("leg", "unit", "words"),
    [
        (0.84, 1.0, "^$"),
        (0.70, 0.01, "^$"),
        (1.02, 0.0254, "^$"),
        (0.437, 0.01, r"legs of 1\.11 m, by the assumed unit in, .* --unit cm for legs of 0\.44 m, or --unit in if"),
        (0.84, 0.3048, r"legs of 0\.276 m, by the assumed unit dm, .* Give --unit ft for legs of 0\.84 m"),
        (
            1.68,
            0.01,
            r"legs of 1\.68 m, by the assumed unit cm, do not fit an adult\. Give another --unit, or --unit cm",
        ),
        (0.874, 0.0001, r"legs of 8\.74 m, by the assumed unit mm, .* Give --unit 1e-04 for legs of 0\.87 m"),
    ],
)
def test_legs_that_do_not_fit_an_adult_are_warned_about(leg: float, unit: float, words: str) -> None:
    _, _, warning = guess_unit(leg / unit)
    assert re.search(words, warning)


def test_a_stated_unit_in_which_legs_are_no_persons_is_warned_about(tmp_path: Path) -> None:
    """As of an FBX or ASF file whose lengths are centimetres, and whose unit is an inch."""
    tall = replace(WALK, skeleton=WALK.skeleton.scaled(2.0), root_positions=2.0 * WALK.root_positions)
    (tmp_path / "walk.glb").write_bytes(dump_glb(tall))
    reading = read_clip(tmp_path / "walk.glb")
    assert reading.unit == 1.0
    assert re.search(
        r"legs of 1\.\d+ m, by the unit that the file states \(1 m\), do not fit a person", reading.warnings[0]
    )
    assert not check_stated_unit(1.0, 0.4)
    assert "another --unit" in guess_unit(1e-310)[2]
    assert "Give --unit cm for legs of 0.87 m, or --unit 0.0254 if" in check_stated_unit(0.0254, 87.4)[0]


def test_hidden_files_are_no_clips(tmp_path: Path) -> None:
    for name in ("walk.bvh", "._walk.bvh", ".walk.c3d", "jog.C3D", "RUN.BVH"):
        (tmp_path / name).write_bytes(b"x")
    assert [file.name for file in clip_files(tmp_path)] == ["RUN.BVH", "walk.bvh"]
    assert [file.name for file in other_files(tmp_path)] == ["jog.C3D"]


def test_a_folder_or_a_broken_link_named_as_a_clip_is_said_to_be_one(tmp_path: Path) -> None:
    (tmp_path / "moves.bvh").mkdir()
    (tmp_path / "old.bvh").symlink_to(tmp_path / "gone.bvh")
    for name, problem in (("moves.bvh", "this is a folder"), ("old.bvh", "this link leads nowhere")):
        with pytest.raises(FormatError, match=rf"{name}: {problem}"):
            read_bytes(tmp_path / name)


def test_a_pointer_of_git_lfs_is_refused_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "walk.glb").write_bytes(b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 5\n")
    with pytest.raises(FormatError, match=r"a pointer of Git LFS, not the file itself\. Run `git lfs pull`"):
        read_clip(tmp_path / "walk.glb")


def test_a_rate_that_is_given_replaces_that_of_the_file(tmp_path: Path) -> None:
    told, untold = read_clip(written(tmp_path), rate=30).clip, read_clip(written(tmp_path)).clip
    assert (untold.rate, told.rate) == (WALK.rate, 30.0)
    np.testing.assert_array_equal(told.rotations, untold.rotations)
    for wrong in (0.0, -30.0, float("nan"), float("inf")):
        with pytest.raises(SettingsError, match=r"frames per second\. Give a number above 0"):
            read_clip(written(tmp_path), rate=wrong)


@pytest.mark.parametrize(("root", "left"), [(None, 0.0), ("Hips", 0.0), ("Reference", 0.0), ("B_Hips", 1.5)])
def test_of_two_bodies_the_one_below_the_given_root_is_read(tmp_path: Path, root: str | None, left: float) -> None:
    reading = read_clip(written(tmp_path, two_bodies(WALK, apart=1.5)), unit="m", root=root)
    other = "read the skeleton 'Hips'; choose another with --root: B_Hips"
    assert (other in reading.notes) == (root is None)
    clip = reading.clip
    names = ["B_" * (left > 0.0) + name for name in WALK.skeleton.names]
    order = [clip.skeleton.index(name) for name in names]
    assert clip.skeleton.names[0] == names[0]
    moved = joint_positions(WALK) + np.array([left, 0.0, 0.0])
    np.testing.assert_allclose(joint_positions(clip)[:, order], moved, atol=1e-4)


def test_an_unknown_root_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MotionError, match=r"unknown joint 'Hip' for --root\. Did you mean 'Hips'"):
        read_clip(written(tmp_path), root="Hip")


def test_leading_frames_are_skipped(tmp_path: Path) -> None:
    clip = read_clip(written(tmp_path), skip_frames=7, unit="m").clip
    np.testing.assert_allclose(clip.root_positions, WALK.root_positions[7:], atol=1e-5)
    with pytest.raises(MotionError, match=r"walk\.bvh: cannot skip 30 of 30 frames"):
        read_clip(written(tmp_path), skip_frames=30)


def test_a_leading_bind_pose_is_noticed(tmp_path: Path) -> None:
    posed = WALK.rotations.copy()
    posed[0] = quaternion.IDENTITY
    with_pose = Clip("walk", WALK.skeleton, WALK.rate, WALK.root_positions, posed)
    assert any("--skip-frames 1" in warning for warning in read_clip(written(tmp_path, with_pose)).warnings)
    assert not read_clip(written(tmp_path)).warnings


def test_a_bind_pose_is_noticed_in_every_real_bvh_and_in_no_amc(real_motion: Path) -> None:
    for path in [*real_motion.glob("06_*.bvh"), *real_motion.glob("16_*.amc")]:
        noticed = any("--skip-frames" in warning for warning in read_clip(path).warnings)
        assert noticed == (path.suffix == ".bvh"), path.name


def test_a_file_of_one_frame_is_a_clip(tmp_path: Path) -> None:
    assert read_clip(written(tmp_path, WALK.frames(0, 1))).clip.frame_count == 1


def test_the_motion_is_kept_when_joints_are_reordered(tmp_path: Path) -> None:
    clip = read_clip(written(tmp_path)).clip
    order = [clip.skeleton.index(name) for name in WALK.skeleton.names]
    np.testing.assert_allclose(joint_positions(clip)[:, order], joint_positions(WALK), atol=1e-4)


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("absent.bvh", None, "absent.bvh: no such file"),
        ("absent.amc", None, "absent.amc: no such file"),
        ("empty.bvh", b"", "empty.bvh: the file is empty"),
        ("blank.amc", b" \n\n", "blank.amc: the file is empty"),
        ("16.asf", b":version 1.10", "this is a skeleton without a motion. Give the .amc beside it"),
        ("walk.c3d", b"\x02P", r"unsupported file type '\.c3d'\. Convert it to \.amc or \.bvh"),
        ("lone_01.amc", b"1\nroot 0 0 0 0 0 0\n", "found no skeleton lone.asf"),
        ("alone.amc", b"1\nroot 0 0 0 0 0 0\n", "found no skeleton alone.asf"),
        ("noise.bvh", bytes(range(256)), "noise.bvh: this is a binary file"),
    ],
)
def test_a_bad_file_is_named(tmp_path: Path, name: str, data: bytes | None, words: str) -> None:
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(MotionError, match=words):
        read_clip(tmp_path / name)


@pytest.mark.parametrize("name", ["clips", "clips.bvh"])
def test_a_folder_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    with pytest.raises(MotionError, match=f"{name}: this is a folder. Give one file in it: .amc or .bvh"):
        read_clip(tmp_path / name)


@pytest.mark.parametrize(
    ("motion", "skeletons", "found"),
    [
        ("a_01.amc", ["a.asf", "b.asf"], "a.asf"),
        ("A_01.AMC", ["A.ASF", "b.asf"], "A.ASF"),
        ("walk.amc", ["walk.asf", "b.asf"], "walk.asf"),
        ("a_01.amc", ["only.asf"], "only.asf"),
    ],
)
def test_the_skeleton_beside_a_motion_is_found(tmp_path: Path, motion: str, skeletons: list[str], found: str) -> None:
    for name in [motion, *skeletons]:
        (tmp_path / name).write_text("nothing")
    with pytest.raises(MotionError, match=f"{found}: the file has no :root"):
        read_clip(tmp_path / motion)


def test_several_skeletons_without_a_matching_name_are_refused(tmp_path: Path) -> None:
    for name in ("c_01.amc", "a.asf", "b.asf"):
        (tmp_path / name).write_text("nothing")
    with pytest.raises(MotionError, match=r"found no skeleton c\.asf in its folder, but 2 other \.asf files"):
        read_clip(tmp_path / "c_01.amc")


def test_a_bad_skeleton_file_is_named_rather_than_the_motion(tmp_path: Path) -> None:
    (tmp_path / "a.asf").write_text("nothing")
    (tmp_path / "a_01.amc").write_text("1\nroot 0 0 0 0 0 0\n")
    with pytest.raises(MotionError, match=r"a\.asf: the file has no :root"):
        read_clip(tmp_path / "a_01.amc")


def test_unknown_joint_names_are_answered_with_a_roles_file_to_fill_in(tmp_path: Path) -> None:
    text = bvh.dump_bvh(WALK).replace(b"LeftLeg", b"Alpha")
    (tmp_path / "odd.bvh").write_bytes(text)
    with pytest.raises(RoleError, match=r"odd\.bvh: no joint found for left_knee"):
        read_clip(tmp_path / "odd.bvh")
    assert read_clip(tmp_path / "odd.bvh", roles={"left_knee": "Alpha"}).clip.frame_count == 30


@pytest.mark.parametrize("documented", [Clip, read_clip, bvh.dump_bvh])
def test_the_example_in_the_docstring_runs(
    documented: Callable[..., object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    [example] = re.findall(r"```python\n(.*?)```", inspect.getdoc(documented) or "", re.DOTALL)
    exec(compile(inspect.cleandoc(example), documented.__name__, "exec"), {})
