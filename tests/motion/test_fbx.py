from __future__ import annotations

import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats.fbx import reader
from motionsplice.motion.formats.fbx.worker import FASTEST, SLOWEST, rate_of
from motionsplice.motion.formats.files import clips_in
from motionsplice.motion.formats.reading import Reading, read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from tests.fbx_files import Variant, dump_fbx

pytest.importorskip("ufbx")

RIGS = Path(__file__).parents[3] / "shared" / "mocap" / "rigs"
WALK, RUN = make("walk", seconds=0.5), replace(make("run", seconds=0.4), name="run fast")
JOINTS = WALK.skeleton.joint_count
AXES = np.asarray(Rotation.random(JOINTS, random_state=1).as_quat())


def read(tmp_path: Path, data: bytes, **options: Any) -> Reading:
    (tmp_path / "walk.fbx").write_bytes(data)
    return read_clip(tmp_path / "walk.fbx", **options)


def assert_same(found: Clip, clip: Clip) -> None:
    """Checks world positions in metres, rate, and that the bind pose has no rotations."""
    assert found.skeleton.names == clip.skeleton.names
    assert found.rate == clip.rate
    np.testing.assert_allclose(joint_positions(found), joint_positions(clip), atol=1e-5)
    np.testing.assert_allclose(found.skeleton.offsets[1:], clip.skeleton.offsets[1:], atol=1e-5)
    assert quaternion.angle(found.rotations, clip.rotations).max() < 1e-5


@pytest.mark.parametrize(
    "variant",
    [
        Variant(),
        Variant(unit=1.0),
        Variant(unit=0.0254, up="z"),
        Variant(up="z", scale=100.0, bone_axes=AXES),
        Variant(kind="Null"),
    ],
)
def test_a_clip_is_read_as_it_was_written(tmp_path: Path, variant: Variant) -> None:
    reading = read(tmp_path, dump_fbx([WALK], variant))
    assert_same(reading.clip, WALK)
    assert reading.unit == pytest.approx(variant.unit)
    np.testing.assert_allclose(reading.clip.skeleton.end_offsets, WALK.skeleton.end_offsets, atol=1e-5)
    assert reading.notes[0] == "it states no bind pose; the pose of its nodes at rest is taken"


@pytest.mark.parametrize("bind", ["pose", "skin"])
def test_the_bind_pose_is_the_stated_one_and_not_that_at_rest(tmp_path: Path, bind: str) -> None:
    variant = Variant(up="z", scale=2.0, bone_axes=AXES, rest=7, bind=bind)
    reading = read(tmp_path, dump_fbx([WALK], variant))
    assert_same(reading.clip, WALK)
    assert not any("bind pose" in note for note in reading.notes)


def test_a_joint_without_a_bind_matrix_is_bound_as_it_rests_on_its_parent(tmp_path: Path) -> None:
    """Exporters list only joints that move a mesh. The hand rests as in frame 7, and so does the arm above it."""
    data = dump_fbx([WALK], Variant(rest=7, bind="pose")).decode()
    hand = WALK.skeleton.index("LeftHand")
    listed = f"Node: {100 + 10 * hand}\n"
    assert data.count(listed) == 1
    clip = read(tmp_path, data.replace(listed, "Node: 0\n").encode()).clip
    np.testing.assert_allclose(joint_positions(clip), joint_positions(WALK), atol=1e-5)
    length = np.linalg.norm(clip.skeleton.offsets - WALK.skeleton.offsets, axis=1)
    assert length.max() < 1e-5  # its offset does not depend on its own rotation
    assert quaternion.angle(clip.rotations[7, hand], quaternion.IDENTITY) < 1e-5


def test_a_unit_that_cannot_be_is_guessed_from_the_legs(tmp_path: Path) -> None:
    data = dump_fbx([WALK], Variant(unit=1.0)).replace(
        b'"UnitScaleFactor", "double", "Number", "",100.0', b'"UnitScaleFactor", "double", "Number", "",1.0'
    )
    reading = read(tmp_path, data)
    assert_same(reading.clip, WALK)
    assert reading.unit == 1.0
    assert any("assumed unit m " in note for note in reading.notes)


def test_each_stack_is_a_clip(tmp_path: Path) -> None:
    path = tmp_path / "moves.fbx"
    path.write_bytes(dump_fbx([WALK, RUN]))
    assert clips_in(path) == {"moves:walk": "walk", "moves:run fast": "run fast"}
    assert_same(read_clip(path, animation="run fast").clip, replace(RUN, skeleton=WALK.skeleton))
    with pytest.raises(
        FormatError, match=r"moves\.fbx: it has 2 animations\. Choose one with --animation: walk, run fast"
    ):
        read_clip(path)
    with pytest.raises(FormatError, match=r"it has no animation 'jump'\. Choose one of run fast, walk"):
        read_clip(path, animation="jump")


def test_stacks_of_one_name_are_numbered(tmp_path: Path) -> None:
    path = tmp_path / "moves.fbx"
    path.write_bytes(dump_fbx([replace(WALK, name="Take.1"), replace(RUN, name="Take"), replace(WALK, name="Take")]))
    assert list(clips_in(path).values()) == ["Take.1", "Take", "Take.001"]


def test_a_file_with_one_stack_is_listed_without_a_child(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: Any, **__: Any) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr(subprocess, "run", none)
    (tmp_path / "walk.fbx").write_bytes(dump_fbx([WALK]))
    assert clips_in(tmp_path / "walk.fbx") == {"walk": None}


def test_stacks_that_move_no_joint_are_left_out(tmp_path: Path) -> None:
    empty = 'AnimationStack: 7, "AnimStack::Take 001", "" {\n}'
    path = tmp_path / "walk.fbx"
    path.write_bytes(dump_fbx([WALK], Variant(objects=(empty,))))
    assert clips_in(path) == {"walk": "walk"}
    assert_same(read_clip(path).clip, WALK)


def test_a_file_without_animation_is_refused(tmp_path: Path) -> None:
    still = dump_fbx([WALK]).replace(b"AnimationCurve: ", b"Nothing: ")
    with pytest.raises(FormatError, match="it has no animation that moves a joint"):
        read(tmp_path, still)


def test_cameras_and_props_are_left_out_and_noted(tmp_path: Path) -> None:
    props = [
        f'Model: {8 + at}, "Model::{name}", "{kind}" {{\n}}'
        for at, (name, kind) in enumerate([("Sword", "Mesh"), ("Producer Front", "Null"), ("Target", "Null")])
    ]
    links = [f'C: "OO",{8 + at},{parent}' for at, parent in enumerate((100, 0, 0))]
    reading = read(tmp_path, dump_fbx([WALK], Variant(objects=tuple(props), connections=tuple(links))))
    assert_same(reading.clip, WALK)
    (note,) = [note for note in reading.notes if note.startswith("left out, not joints: ")]
    assert sorted(note.partition(": ")[2].split(", ")) == ["Producer Front", "Sword", "Target"]


@pytest.mark.parametrize(("stated", "wanted"), [(30.0, 60.0), (60.0, 60.0), (120.0, 120.0), (25.0, 60.0), (1e9, 60.0)])
def test_the_rate_is_the_files_if_keys_lie_on_its_frames_and_else_that_of_the_keys(
    tmp_path: Path, stated: float, wanted: float
) -> None:
    assert WALK.rate == 60.0
    clip = read(tmp_path, dump_fbx([WALK], Variant(rate=stated))).clip
    assert clip.rate == wanted
    np.testing.assert_allclose(joint_positions(clip)[:: int(wanted / 60.0)], joint_positions(WALK), atol=1e-5)


def test_curves_are_followed_between_keys(tmp_path: Path) -> None:
    """A file at 60 frames per second with keys at 30: frames between them lie on the cubic, not on the chord."""
    clip = replace(WALK, rate=30.0)
    cubic = dump_fbx([clip], Variant(rate=60.0))
    # Auto tangents (0x108), the flag that Maya and Max write.
    cubic = cubic.replace(b"KeyAttrFlags: *1 {\na: 4\n", b"KeyAttrFlags: *1 {\na: 264\n")
    found = read(tmp_path, cubic).clip
    assert found.rate == 60.0
    assert found.frame_count == 2 * clip.frame_count - 1
    np.testing.assert_allclose(joint_positions(found)[::2], joint_positions(clip), atol=1e-5)
    x = clip.root_positions
    wanted = 0.5 * (x[1:-2] + x[2:-1]) + (x[2:-1] - x[:-3] - x[3:] + x[1:-2]) / 16.0  # Catmull-Rom, half-way
    np.testing.assert_allclose(found.root_positions[3:-3:2], wanted, atol=1e-4)


@pytest.mark.parametrize(
    "data", [b"not a motion", b"HIERARCHY\nROOT Hips\n", bytes(1000), b"Kaydara FBX Binary  \x00\x1a\x00"]
)
def test_other_files_are_refused(tmp_path: Path, data: bytes) -> None:
    with pytest.raises(FormatError, match=r"walk\.fbx: (not an FBX file, or a damaged one|the file is empty)"):
        read(tmp_path, data)


def test_a_cut_file_is_refused(tmp_path: Path) -> None:
    data = dump_fbx([WALK])
    for part in (0.3, 0.6, 0.9):
        with pytest.raises(FormatError, match=r"not an FBX file, or a damaged one \(|no animation that moves a joint"):
            read(tmp_path, data[: int(part * len(data))])


@settings(max_examples=40)
@given(
    place=st.floats(0.0, 1.0),
    length=st.integers(0, 30),
    new=st.sampled_from([b"", b"1e308", b"nan", b"-1", b"{", b'"']),
)
def test_damaged_files_give_typed_errors(
    tmp_path_factory: pytest.TempPathFactory, place: float, length: int, new: bytes
) -> None:
    data = dump_fbx([WALK.frames(0, 4)], Variant(bind="skin"))
    at = int(place * len(data))
    with suppress(MotionError):
        read(tmp_path_factory.mktemp("damaged"), data[:at] + new + data[at + length :])


def test_a_motion_far_larger_than_its_file_is_refused(tmp_path: Path) -> None:
    stop = b'"LocalStop", "KTime", "Time", "",'
    data = dump_fbx([WALK])
    endless = data.replace(stop, stop + b"9999999")
    assert endless != data
    with pytest.raises(FormatError, match="s of 28 nodes at 60 frames per second take too much memory"):
        read(tmp_path, endless)


def fake_worker(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, program: str) -> None:
    """Replaces the child process by another program."""
    (tmp_path / "worker.py").write_text(program)
    monkeypatch.setattr(reader, "WORKER", tmp_path / "worker.py")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
def test_a_child_that_crashes_is_an_error_of_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_worker(monkeypatch, tmp_path, "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    with pytest.raises(FormatError, match=r"walk\.fbx: reading it ended with signal 11\. Export it again"):
        read(tmp_path, dump_fbx([WALK]))


def test_a_child_that_fails_says_how(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_worker(monkeypatch, tmp_path, "import no_such_module")
    with pytest.raises(FormatError, match="reading it failed: ModuleNotFoundError: No module named 'no_such_module'"):
        read(tmp_path, dump_fbx([WALK]))
    fake_worker(monkeypatch, tmp_path, "import os; os._exit(3)")
    with pytest.raises(FormatError, match="reading it failed: exit code 3"):
        read(tmp_path, dump_fbx([WALK]))


def test_a_child_that_takes_too_long_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_worker(monkeypatch, tmp_path, "import time; time.sleep(60)")
    monkeypatch.setattr(reader, "SECONDS", 0.2)
    monkeypatch.setattr(reader, "SECONDS_PER_BYTE", 0.0)
    with pytest.raises(FormatError, match=r"reading it takes more than 0\.2 s"):
        read(tmp_path, dump_fbx([WALK]))


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits a process's memory")
def test_a_child_that_takes_too_much_memory_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "MEMORY", 60_000_000)
    monkeypatch.setattr(reader, "MEMORY_PER_BYTE", 0)
    assert read(tmp_path, dump_fbx([WALK])).clip.frame_count == WALK.frame_count
    with pytest.raises(FormatError, match=r"it takes too much memory\. Export the armature without meshes"):
        read(tmp_path, dump_fbx([WALK]) + 60_000_000 * b" ")


def test_a_child_that_cannot_be_started_is_an_error_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", str(tmp_path / "no python"))
    with pytest.raises(FormatError, match="the process that reads FBX files cannot be started: No such file"):
        read(tmp_path, dump_fbx([WALK]))


def test_without_the_extra_the_error_says_how_to_install_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "find_spec", lambda _: None)
    with pytest.raises(FormatError, match=r"FBX files need the package ufbx\. Run: pip install 'motionsplice\[fbx\]'"):
        read(tmp_path, dump_fbx([WALK]))


@pytest.mark.skipif(not RIGS.is_dir(), reason="real rigs not found (../shared/mocap/rigs)")
@pytest.mark.parametrize(("name", "frames"), [("crossarms", 259), ("jog", 25), ("run", 21), ("walk", 41)])
def test_real_files_are_read(name: str, frames: int) -> None:
    """3ds Max Biped, exported by the FBX SDK in centimetres and Y up."""
    reading = read_clip(RIGS / f"{name}.fbx", roles={"left_wrist": "Lefthand"})
    assert (reading.clip.rate, reading.clip.frame_count) == (30.0, frames)
    assert reading.roles.leg_length(reading.clip.skeleton) == pytest.approx(0.9296, abs=1e-4)
    assert reading.unit == pytest.approx(0.01)
    assert clips_in(RIGS / f"{name}.fbx") == {name: None}


@given(
    stated=st.sampled_from([24.0, 25.0, 29.97002997, 30.0, 60.0, 120.0]),
    start=st.floats(-10.0, 10.0),
    frames=st.sets(st.integers(0, 500), min_size=1, max_size=60),
)
def test_keys_on_some_of_the_frames_leave_the_rate_as_stated(stated: float, start: float, frames: set[int]) -> None:
    assert rate_of([start + frame / stated for frame in sorted(frames)], start, stated) == stated


@given(
    stated=st.sampled_from([24.0, 25.0, 30.0]),
    own=st.sampled_from([50.0, 59.94005994, 60.0, 100.0, 119.88011988]),
    first=st.integers(0, 1000),
    count=st.integers(20, 300),
)
def test_keys_between_the_frames_bring_their_own_rate(stated: float, own: float, first: int, count: int) -> None:
    keys = [(first + frame) / own for frame in range(count)]
    assert rate_of(keys, 0.0, stated) == pytest.approx(own, abs=1e-6)


@given(keys=st.lists(st.floats(0.0, 100.0), min_size=1, max_size=50, unique=True), stated=st.floats())
def test_a_rate_is_always_one_that_can_be(keys: list[float], stated: float) -> None:
    assert SLOWEST <= rate_of(sorted(keys), 0.0, stated) <= FASTEST
