"""The short forms of `python -m tests.hardening.killed`, `.power_loss` and `.failing_disk`."""

from __future__ import annotations

import errno
from pathlib import Path
from random import Random

import pytest

from motionsplice.precompute.job import cache, written
from motionsplice.runtime.format.manifest import MANIFEST
from tests.hardening import failing_disk, killed, power_loss
from tests.hardening.disk import Disk, Operation, recorded
from tests.hardening.power_loss import Survivors
from tests.hardening.replacement import DisturbedError, Replacement


@pytest.fixture(scope="module")
def replacement(tmp_path_factory: pytest.TempPathFactory) -> Replacement:
    return Replacement.make(tmp_path_factory.mktemp("replacement"))


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Replacement:
    return Replacement.make(tmp_path_factory.mktemp("first"), afresh=True)


def test_killed_jobs_leave_the_old_or_the_new_bank(replacement: Replacement, tmp_path: Path) -> None:
    assert killed.check(replacement, tmp_path / "bank", 4, seed=1).total() == 4


def test_a_power_cut_leaves_the_old_or_the_new_bank(replacement: Replacement, tmp_path: Path) -> None:
    assert power_loss.check(replacement, tmp_path, 2, every=12) > 14


def test_a_power_cut_leaves_no_part_of_a_first_bank(first: Replacement, tmp_path: Path) -> None:
    assert power_loss.check(first, tmp_path, 2, every=12) > 14


def test_what_fails_on_the_disk_is_a_typed_error_and_leaves_the_old_or_the_new_bank(
    replacement: Replacement, tmp_path: Path
) -> None:
    assert failing_disk.check(replacement, tmp_path / "bank", [errno.ENOSPC], every=16) > 8


def test_a_bank_that_is_not_synced_is_found(
    replacement: Replacement, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(written, "_sync", lambda path: None)
    with pytest.raises(DisturbedError, match=r"neither the old bank nor the new one|the new bank is lost"):
        power_loss.check(replacement, tmp_path, 3, every=4)


def test_what_a_job_leaves_over_is_found(
    replacement: Replacement, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replacement.begin(tmp_path / "bank")
    monkeypatch.setattr(cache.Cache, "keep_only", lambda self, keys: None)
    with pytest.raises(DisturbedError, match=r"left over: .'cache/"):
        replacement.check_rerun(tmp_path / "bank")
    (tmp_path / "bank" / MANIFEST).write_bytes(b"torn")
    with pytest.raises(DisturbedError, match="neither the old bank nor the new one"):
        replacement.check_whole(tmp_path / "bank")


def test_operations_are_recorded_and_fail(tmp_path: Path) -> None:
    file, other = tmp_path / "a", tmp_path / "b"
    with recorded(Disk(tmp_path, "write", 2, errno.EIO)) as disk:
        file.write_bytes(b"abc")
        file.replace(other)
        with pytest.raises(OSError, match="Input/output error"):
            file.write_bytes(b"abcd")
    assert [one.kind for one in disk.log] == ["create", "write", "rename", "create"]
    assert (disk.log[1].data, disk.log[2].inode, disk.failed) == (b"abc", disk.log[0].inode, True)
    assert (other.read_bytes(), file.read_bytes()) == (b"abc", b"ab")


def test_a_power_cut_loses_what_is_not_synced(tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_bytes(b"old")
    left = Survivors.of(tmp_path)
    for one in (
        Operation("create", new, inode=7),
        Operation("write", new, inode=7, data=b"new"),
        Operation("rename", old, new, inode=7),
    ):
        left.do(one)
    draw = Random(0)
    assert left.left(draw, 0.0) == {old: b"old"}
    assert left.left(draw, 1.0) == {old: b"new"}
    contents = {(files := left.left(draw, 0.5)).get(old, files.get(new)) for _ in range(100)}
    assert {b"old", b"", b"new", b"n", b"ne"} >= contents > {b"old", b"", b"new"}
    left.do(Operation("sync", new, inode=7))
    left.do(Operation("sync names", tmp_path))
    assert left.left(draw, 0.0) == {old: b"new"}
