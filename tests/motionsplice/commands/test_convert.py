from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from typer.testing import CliRunner

from motionsplice.cli import app
from motionsplice.commands import convert
from motionsplice.commands.convert import at_rate
from motionsplice.commands.outputs import WRITTEN
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import MotionError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.files import WRITERS
from motionsplice.motion.formats.gltf.reader import animation_names
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from tests.characters import character_file
from tests.conftest import COUNTING
from tests.rigs import with_bones_above

WALK = make("walk", seconds=1.0)


@pytest.fixture(autouse=True)
def _wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(convert, "console", Console(width=200))


def run(*arguments: object) -> str:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.output


def same_motion(file: Path, clip: Clip) -> None:
    found = read_clip(file).clip
    joints = [clip.skeleton.index(name) for name in found.skeleton.names]
    assert len(joints) == clip.skeleton.joint_count
    assert (found.frame_count, round(found.rate, 3)) == (clip.frame_count, clip.rate)
    np.testing.assert_allclose(joint_positions(found), joint_positions(clip)[:, joints], atol=2e-5)


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    (tmp_path / "walk.bvh").write_bytes(dump_bvh(WALK))
    return tmp_path / "walk.bvh"


@pytest.fixture
def hero(tmp_path: Path) -> Path:
    (tmp_path / "hero.vrm").write_bytes(character_file(WALK.skeleton.scaled(0.8), scale=0.01, seed=1))
    return tmp_path / "hero.vrm"


def test_a_motion_goes_through_all_formats(walk: Path, tmp_path: Path) -> None:
    assert tuple(WRITERS) == WRITTEN
    before = walk
    for number, suffix in enumerate([*WRITTEN, *reversed(WRITTEN)]):
        after = tmp_path / f"{number}{suffix}"
        run("convert", before, after)
        same_motion(after, WALK)
        before = after


def test_what_was_understood_is_printed(walk: Path, tmp_path: Path) -> None:
    output = run("convert", walk, tmp_path / "out.glb")
    for line in (
        "motion    'walk', 61 frames at 60 per second, 1.00 s",
        "skeleton  22 joints, 'Hips' is the root",
        "unit      1 m; the legs are 0.87 m long",
        "trunk     pelvis Spine, spine Spine1 + Spine2, neck Neck, head Head",
        "left      hip LeftUpLeg, knee LeftLeg, ankle LeftFoot, toe LeftToeBase, shoulder LeftArm, elbow LeftForeArm, "
        "wrist LeftHand, no finger joints",
        "note      assumed unit m ",
        "out.glb: 61 frames at 60 per second, 1.00 s",
    ):
        assert line in output


@given(st.integers(1, 40), st.sampled_from([24.0, 30.0, 59.94, 120.0]), st.sampled_from([24.0, 25.0, 60.0, 144.0]))
def test_another_rate_keeps_the_length_and_the_last_frame(frames: int, own: float, rate: float) -> None:
    clip = Clip("walk", WALK.skeleton, own, WALK.root_positions[:frames], WALK.rotations[:frames])
    found = at_rate(clip, rate)
    assert found.rate == rate
    assert abs(found.duration - clip.duration) <= 0.5 / rate + 1e-9
    np.testing.assert_array_equal(found.root_positions[0], clip.root_positions[0])
    step = np.abs(np.diff(clip.root_positions, axis=0)).max(initial=0.0)
    apart = np.abs(found.root_positions[-1] - clip.root_positions[-1]).max()
    assert apart <= step * (0.5 * own / rate) + 1e-9


def test_frames_per_second_are_those_asked_for(walk: Path, tmp_path: Path) -> None:
    assert "25 frames at 24 per second, 1.00 s" in run("convert", walk, tmp_path / "out.glb", "--fps", 24)
    same_motion(tmp_path / "out.glb", at_rate(WALK, 24.0))


def test_a_motion_is_put_on_the_skeleton_of_another_file(walk: Path, hero: Path, tmp_path: Path) -> None:
    small = make("walk", seconds=0.2)
    small = Clip("small", WALK.skeleton.scaled(0.8), small.rate, small.root_positions, small.rotations)
    (tmp_path / "small.bvh").write_bytes(dump_bvh(small))
    for other in ("small.bvh", "hero.vrm"):
        output = run("convert", walk, tmp_path / "out.glb", "--skeleton", tmp_path / other)
        assert f"on the skeleton of {tmp_path / other}" in output
        found = read_clip(tmp_path / "out.glb").clip
        np.testing.assert_allclose(joint_positions(found), 0.8 * joint_positions(WALK), atol=2e-5)


def test_a_motion_is_written_into_a_character(walk: Path, hero: Path, bank: Bank, tmp_path: Path) -> None:
    run("convert", walk, tmp_path / "a.vrm", "--character", hero)
    run(
        "splice",
        bank.path,
        "--locomotion",
        "walk",
        "--action",
        "wave",
        "--out",
        tmp_path / "b.glb",
        "--character",
        hero,
    )
    assert animation_names((tmp_path / "b.glb").read_bytes()) == ["walk+wave"]
    for name, clip in (("a.vrm", WALK), ("b.glb", Evaluator(bank).clip(Splice("walk", "wave")))):
        found = read_clip(tmp_path / name).clip
        joints = [clip.skeleton.index(joint) for joint in found.skeleton.names]
        np.testing.assert_allclose(joint_positions(found), 0.8 * joint_positions(clip)[:, joints], atol=3e-5)


def test_a_motion_of_another_rig_is_retargeted_to_the_character(hero: Path, tmp_path: Path) -> None:
    other = with_bones_above(WALK, {"LeftHand": "LeftForeArmTwist", "Head": "Neck1"})
    (tmp_path / "other.bvh").write_bytes(dump_bvh(other))
    output = run("convert", tmp_path / "other.bvh", tmp_path / "out.vrm", "--character", hero)
    assert f"on the skeleton of {hero}\nretargeted by roles: the rigs have different topologies" in output
    found = read_clip(tmp_path / "out.vrm").clip
    np.testing.assert_allclose(joint_positions(found), 0.8 * joint_positions(WALK), atol=2e-5)


def test_hands_are_written_into_a_character(hands_folder: Path, tmp_path: Path) -> None:
    (tmp_path / "hero.glb").write_bytes(character_file(COUNTING.truth.skeleton, scale=100.0, seed=1))
    files = hands_folder / "counting.bvh", hands_folder / "counting_hands.bvh"
    for out, options in (("a.glb", ["--character", tmp_path / "hero.glb"]), ("b.vrma", [])):
        run("hands", *files, "--unit", "m", "--out", tmp_path / out, *options)
    found, wanted = (read_clip(tmp_path / out).clip for out in ("a.glb", "b.vrma"))
    joints = [wanted.skeleton.index(name) for name in found.skeleton.names]
    assert len(joints) == 52
    np.testing.assert_allclose(joint_positions(found), joint_positions(wanted)[:, joints], atol=2e-4)


def test_what_cannot_be_written_is_refused(walk: Path, hero: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.glb"
    for arguments, words in (
        ([tmp_path / "out.fbx"], "OUT .*out.fbx: only .bvh or .glb or .gltf or .vrma can be written"),
        ([tmp_path / "out.bvh", "--character", hero], "only .glb or .vrm can be written with the character .*hero.vrm"),
        ([out, "--character", walk], "walk.bvh: this is not a GLB file. Export the character as .glb or .vrm"),
        (
            [tmp_path / "x.fbx", "--character", tmp_path / "x.fbx"],
            "x.fbx: this is not a GLB file. Export the character",
        ),
        ([out, "--character", hero, "--skeleton", walk], "Leave out --skeleton or --character"),
        ([out, "--character", tmp_path / "absent.glb"], "absent.glb: no such file"),
    ):
        with pytest.raises(MotionError, match=words):
            run("convert", walk, *arguments)
        assert not out.exists()
