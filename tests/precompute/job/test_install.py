from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion.errors import BankError, MotionError
from motionsplice.precompute.job.alone import LOCK
from motionsplice.precompute.job.install import install_bank
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format import tables
from motionsplice.runtime.format.manifest import TABLES
from motionsplice.runtime.format.tables import TABLE_FOLDER
from tests.precompute.job.test_job import files_of


def install(source: Path, place: Path) -> str:
    return install_bank(source, place, lambda stage, done, total: None)


@pytest.fixture(scope="module")
def other(clip_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """A smaller bank of the same clips."""
    folder = tmp_path_factory.mktemp("other")
    build_bank([clip_folder / "walk.bvh", clip_folder / "run.bvh"], folder, baseline="walk")
    return Bank.open(folder)


@pytest.fixture
def served(bank: Bank, tmp_path: Path) -> Path:
    install(bank.path, tmp_path / "served")
    return tmp_path / "served"


def test_a_bank_that_is_in_use_stays_as_it_was(
    served: Path, bank: Bank, other: Bank, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "SMALL", 0)
    mapped = Bank.open(served)
    assert install(other.path, served) == other.digest
    assert Bank.open(served).digest == other.digest
    for name, table in bank.tables.items():
        np.testing.assert_array_equal(mapped.tables[name], table)
    install(bank.path, served)
    assert files_of(served).items() >= files_of(bank.path).items()


def test_tables_that_are_missing_or_damaged_are_replaced(served: Path, bank: Bank) -> None:
    first, second, third, *_ = sorted((served / TABLE_FOLDER).iterdir())
    first.unlink()
    second.write_bytes(b"")
    (served / TABLE_FOLDER / ".table.1.2").touch()  # of a job that was killed
    kept = third.stat().st_ino
    install(bank.path, served)
    assert files_of(served) == files_of(bank.path)
    assert third.stat().st_ino == kept


def test_a_damaged_bank_is_not_installed(served: Path, bank: Bank, tmp_path: Path) -> None:
    damaged = Path(shutil.copytree(bank.path, tmp_path / "damaged"))
    file = max((damaged / TABLE_FOLDER).iterdir(), key=lambda one: one.stat().st_size)
    file.write_bytes(file.read_bytes()[:-1] + b"\x00")
    before = files_of(served)
    with pytest.raises(BankError, match=file.name):
        install(damaged, served)
    with pytest.raises(BankError, match="not a bank"):
        install(tmp_path, served)
    assert files_of(served) == before


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[int], None]]:
    """Makes the nth call fail that syncs or renames a file."""
    calls = [0, 0]

    def fails(call: Callable[..., object]) -> Callable[..., object]:
        def wrapped(*given: object) -> object:
            calls[0] += 1
            if calls[0] == calls[1]:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            return call(*given)

        return wrapped

    def nth(number: int) -> None:
        calls[:] = 0, number

    monkeypatch.setattr(os, "fsync", fails(os.fsync))
    monkeypatch.setattr(Path, "replace", fails(Path.replace))
    yield nth
    nth(0)


@pytest.mark.parametrize("command", ["install", "build"])
def test_after_any_failed_write_the_bank_is_the_old_or_the_new_one(
    served: Path, bank: Bank, other: Bank, clip_folder: Path, failing: Callable[[int], None], command: str
) -> None:
    clips = [clip_folder / "walk.bvh", clip_folder / "run.bvh"]
    for number in count(1):
        failing(0)
        install(bank.path, served)
        failing(number)
        try:
            if command == "install":
                install(other.path, served)
            else:
                build_bank(clips, served, baseline="walk")
        except MotionError as error:
            named = error.file
        else:
            break
        assert named.startswith(str(served))
        failing(0)
        assert Bank.open(served).digest in (bank.digest, other.digest)
        assert {file.name for file in served.rglob(".*")} == {LOCK}
    assert Bank.open(served).digest == other.digest
    assert number > len(TABLES)
