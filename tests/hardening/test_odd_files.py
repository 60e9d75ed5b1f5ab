"""Folders and files that are unreadable, looped, read-only or no files are refused by typed errors, or do no harm."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from motionsplice.motion.errors import BankError, ClipError, FormatError, MotionError, SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.gltf.writer import dump_gltf
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.outcome import Outcome
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from tests.hardening.fuzz.banks import small_bank

CLIP = make("walk", seed=1, seconds=2.5, rate=30.0)
NOBODY = 65534
SEALED = 0o000


@contextmanager
def sealed(path: Path, mode: int = SEALED) -> Iterator[None]:
    """Changes what a file or folder permits, and obeys it meanwhile, as root would not."""
    before, user = path.stat().st_mode, os.geteuid()
    path.chmod(mode)
    if user == 0:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(user)
        path.chmod(before)


@pytest.fixture(scope="module", autouse=True)
def loaded(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Has Python load all modules that a job needs, which may lie where nobody may read."""
    folder = tmp_path_factory.mktemp("loaded")
    (folder / "walk.bvh").write_bytes(dump_bvh(CLIP))
    (folder / "walk.gltf").write_bytes(dump_gltf(CLIP))
    read_clip(folder / "walk.gltf")
    build_bank([folder / "walk.bvh"], folder / "bank", baseline="walk")
    Bank.open(folder / "bank")


@pytest.fixture
def clips(tmp_path: Path) -> Path:
    """A folder with a walk, which anybody may enter."""
    shared = Path(tempfile.gettempdir()).resolve()
    for folder in (tmp_path, *tmp_path.parents):
        if shared in folder.resolve().parents:
            folder.chmod(0o755)
    folder = tmp_path / "clips"
    folder.mkdir()
    (folder / "walk.bvh").write_bytes(dump_bvh(CLIP))
    return folder


def build(clips: Path) -> Outcome:
    return build_bank([clips], clips.parent / "bank", baseline="walk")


def test_a_file_that_may_not_be_read_is_refused(clips: Path) -> None:
    with sealed(clips / "walk.bvh"), pytest.raises(FormatError, match="cannot be read: Permission denied"):
        read_clip(clips / "walk.bvh")


@pytest.mark.parametrize("mode", [SEALED, 0o444])
def test_a_folder_that_may_not_be_read_is_refused(clips: Path, mode: int) -> None:
    with sealed(clips, mode):
        for name in ("walk.bvh", "walk.amc", "walk.gltf"):
            with pytest.raises(FormatError):
                read_clip(clips / name)
        with pytest.raises(MotionError):
            build(clips)
        with pytest.raises(MotionError):
            build_bank([clips / "walk.bvh"], clips.parent / "bank")


def test_a_clip_that_may_not_be_read_fails_alone(clips: Path) -> None:
    shutil.copy(clips / "walk.bvh", clips / "other.bvh")
    clips.parent.chmod(0o777)
    with sealed(clips / "other.bvh"):
        outcome = build(clips)
    assert outcome.clips == ("walk",)
    assert "cannot be read: Permission denied" in str(outcome.failed["other"])


@pytest.mark.parametrize("name", ["clips.toml", "hands.toml"])
def test_settings_that_cannot_be_read_are_not_ignored(clips: Path, name: str) -> None:
    (clips / name).symlink_to(clips / name)
    with pytest.raises(SettingsError, match=f"{name}: the file cannot be read: .*symbolic links"):
        build(clips)
    (clips / name).unlink()
    (clips / name).symlink_to("nowhere")
    with pytest.raises(SettingsError, match=f"{name}: the file cannot be read: No such file"):
        build(clips)


def test_links_in_circles_are_left_out(clips: Path) -> None:
    (clips / "loop.bvh").symlink_to("loop.bvh")
    (clips / "back").symlink_to(clips, target_is_directory=True)
    outcome = build(clips)
    assert outcome.clips == ("walk",)
    assert set(outcome.failed) == {"loop"}
    with pytest.raises(ClipError, match="not found"):
        build_bank([clips / "loop.bvh"], clips.parent / "bank")


def test_a_buffer_that_is_a_link_in_a_circle_is_refused(clips: Path) -> None:
    (clips / "walk.gltf").write_bytes(dump_gltf(CLIP).replace(b"data:application/octet-stream;base64,", b"loop#"))
    text = (clips / "walk.gltf").read_bytes()
    begin = text.index(b'"loop#')
    (clips / "walk.gltf").write_bytes(text[:begin] + b'"loop.bin"' + text[text.index(b'"', begin + 1) + 1 :])
    (clips / "loop.bin").symlink_to("loop.bin")
    with pytest.raises(FormatError, match=r"loop\.bin: the file cannot be read: Too many"):
        read_clip(clips / "walk.gltf")
    (clips / "walk.bvh").unlink()
    with pytest.raises(MotionError):
        build(clips)


def test_a_pipe_or_a_device_is_not_waited_for(clips: Path) -> None:
    os.mkfifo(clips / "pipe.bvh")
    (clips / "zeros.bvh").symlink_to("/dev/zero")
    outcome = build(clips)
    assert outcome.clips == ("walk",)
    for name in ("pipe", "zeros"):
        assert "this is a pipe or a device, not a file" in str(outcome.failed[name])


def test_a_bank_is_not_written_where_nobody_may_write(clips: Path) -> None:
    with sealed(clips.parent, 0o555), pytest.raises(BankError, match="cannot be written: Permission denied"):
        build(clips)
    build(clips)
    (clips / "walk.bvh").write_bytes(dump_bvh(make("walk", seed=2, seconds=2.5)))
    before = Bank.open(clips.parent / "bank").digest
    with sealed(clips.parent / "bank", 0o555), pytest.raises(MotionError, match="cannot be written: Permission denied"):
        build(clips)
    assert Bank.open(clips.parent / "bank").digest == before
    with pytest.raises(BankError, match=r"cannot be written: (File exists|Not a directory)"):
        build_bank([clips], clips / "walk.bvh", baseline="walk")


def test_a_bank_on_a_read_only_file_system_is_used(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(small_bank().path, tmp_path / "bank"))
    for one in (tmp_path.parents[1], tmp_path.parent, tmp_path, folder, folder / "tables"):
        one.chmod(0o555)
    with sealed(folder / "manifest.msgpack", 0o444):
        bank = Bank.open(folder)
    assert Evaluator(bank).pose(Splice("clip 0"), time=0.0).rotations.shape[1] == bank.skeleton.joint_count


@pytest.mark.parametrize("name", ["manifest.msgpack", "tables", ""])
def test_a_bank_that_may_not_be_read_is_refused(tmp_path: Path, name: str) -> None:
    folder = Path(shutil.copytree(small_bank().path, tmp_path / "bank"))
    for one in (tmp_path.parents[1], tmp_path.parent, tmp_path, folder):
        one.chmod(0o755)
    with sealed(folder / name), pytest.raises(BankError, match=r"cannot be read|not found"):
        Bank.open(folder)
