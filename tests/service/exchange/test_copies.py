from __future__ import annotations

import shutil
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion.errors import BankError, SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format import tables
from motionsplice.service.exchange import copies
from motionsplice.service.exchange.copies import READ_ONLY, folder_for, from_copies


@pytest.fixture
def mapped(bank: Bank, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bank:
    """A copy of the bank, which tests damage, with mapped tables."""
    monkeypatch.setattr(tables, "SMALL", 0)
    shutil.copytree(bank.path, tmp_path / "bank", ignore=shutil.ignore_patterns("cache"))
    return Bank.open(tmp_path / "bank")


def copied(folder: Path) -> list[Path]:
    return sorted((folder / tables.TABLE_FOLDER).iterdir())


def test_tables_are_mapped_from_copies_that_nobody_writes_to(bank: Bank, mapped: Bank, tmp_path: Path) -> None:
    copy = from_copies(mapped, tmp_path / "copies")
    assert copied(tmp_path / "copies") == sorted(tables.table_files(tmp_path / "copies", bank.manifest).values())
    for file in copied(tmp_path / "copies"):
        assert file.stat().st_mode & 0o777 == READ_ONLY
    for name, table in bank.tables.items():
        base = copy.tables[name].base
        assert isinstance(base, np.memmap)
        assert Path(str(base.filename)).parent == tmp_path / "copies" / tables.TABLE_FOLDER
        np.testing.assert_array_equal(copy.tables[name], table)
    copy.verify()


def test_workers_that_begin_at_once_copy_each_table_once(
    mapped: Bank, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copyfile, sources, barrier = shutil.copyfile, list[Path](), threading.Barrier(4)

    def counted(source: Path, sink: Path) -> None:
        sources.append(source)
        copyfile(source, sink)

    def work(_: int) -> Bank:
        barrier.wait()
        return from_copies(mapped, tmp_path / "copies")

    monkeypatch.setattr(shutil, "copyfile", counted)
    with ThreadPoolExecutor(4) as pool:
        for copy in pool.map(work, range(4)):
            np.testing.assert_array_equal(copy.tables["upper"], mapped.tables["upper"])
    assert sorted(sources) == sorted(mapped.files.values())


def test_a_restart_copies_only_what_is_damaged_and_removes_what_is_of_another_bank(
    mapped: Bank, tmp_path: Path
) -> None:
    from_copies(mapped, tmp_path)
    before = {file: file.stat().st_ino for file in copied(tmp_path)}
    damaged, *_ = before
    damaged.chmod(0o600)
    damaged.write_bytes(damaged.read_bytes()[:-1])
    for name in (f"{'0' * 32}.npy", f"{damaged.stem}.partial"):
        (damaged.parent / name).touch(READ_ONLY)
    from_copies(mapped, tmp_path).verify()
    after = {file: file.stat().st_ino for file in copied(tmp_path)}
    assert {file for file in after if after[file] != before[file]} == {damaged}
    assert copies._holds(damaged)


def test_a_table_that_was_altered_is_refused_and_not_kept(mapped: Bank, tmp_path: Path) -> None:
    file = mapped.files["upper"]
    file.write_bytes(file.read_bytes()[:-1])
    with pytest.raises(BankError, match=f"{file.name}: table 'upper' was cut short or altered"):
        from_copies(mapped, tmp_path / "copies")
    assert tables.table_files(tmp_path / "copies", mapped.manifest)["upper"] not in copied(tmp_path / "copies")
    assert not list((tmp_path / "copies").rglob("*.partial"))


def test_each_place_has_a_folder_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first, second = (folder_for(f"s3://bucket/{name}", None) for name in "ab")
    assert first != second
    assert first.parent == second.parent == tmp_path / "motionsplice" / "banks"


def test_a_user_without_a_home_is_asked_for_a_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    with pytest.raises(SettingsError, match="--copies"):
        folder_for("/banks/one", None)
    assert folder_for("/banks/one", tmp_path).parent == tmp_path
