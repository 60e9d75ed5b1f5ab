from __future__ import annotations

import asyncio
import errno
import fcntl
import gc
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format import tables
from motionsplice.runtime.format.manifest import MANIFEST
from motionsplice.service.exchange import leases as leasing
from motionsplice.service.exchange.leases import Leases, move_into_memory

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux has leases")

OVERWRITTEN = """
import asyncio, errno, fcntl, sys
from pathlib import Path
import numpy as np
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format import tables
from motionsplice.service.exchange.leases import Leases

whole, place, copies = Bank.open(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
if sys.argv[4] == "no lease":
    system = fcntl.fcntl
    def refuse(descriptor, command, *rest):
        if command == fcntl.F_SETLEASE:
            raise OSError(errno.EACCES, "Permission denied")
        return system(descriptor, command, *rest)
    fcntl.fcntl = refuse
tables.SMALL = 0
leases = Leases(copies)
bank = leases.hold(Bank.open(place))

async def overwrite():
    keep = asyncio.create_task(leases.keep(0.01))
    for file in bank.files.values():
        process = await asyncio.create_subprocess_exec("cp", "/dev/null", file)
        assert await process.wait() == 0
        assert file.stat().st_size == 0

asyncio.run(overwrite())
for name, table in whole.tables.items():
    np.testing.assert_array_equal(bank.tables[name], table)
"""


@pytest.fixture
def place(bank: Bank, tmp_path: Path) -> Path:
    """A copy of the bank, which tests overwrite."""
    shutil.copytree(bank.path, tmp_path / "bank", ignore=shutil.ignore_patterns("cache"))
    with (tmp_path / "bank" / MANIFEST).open("rb") as file:
        try:
            fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_RDLCK)
        except OSError:
            pytest.skip("this file system has no leases")
    return tmp_path / "bank"


@pytest.mark.parametrize(
    ("lease", "copies", "status"),
    [("lease", "/dev/null", 0), ("no lease", "copies", 0), ("no lease", "/dev/null", -signal.SIGBUS)],
)
def test_mapped_tables_that_are_leased_or_copied_survive_that_their_files_are_overwritten(
    bank: Bank, place: Path, lease: str, copies: str, status: int
) -> None:
    project = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    command = [sys.executable, "-c", OVERWRITTEN, str(bank.path), str(place), str(place.parent / copies), lease]
    done = subprocess.run(command, env=project, capture_output=True, text=True, check=False)
    assert done.returncode == status, done.stderr


@pytest.fixture
def mapped(place: Path, monkeypatch: pytest.MonkeyPatch) -> Bank:
    monkeypatch.setattr(tables, "SMALL", 0)
    return Bank.open(place)


def test_a_table_stays_at_its_address_when_it_moves_into_memory(bank: Bank, mapped: Bank) -> None:
    for name, table in mapped.tables.items():
        address = table.ctypes.data
        move_into_memory(table)
        assert table.ctypes.data == address
        np.testing.assert_array_equal(table, bank.tables[name])


def test_leases_are_given_back_when_the_bank_is_not_used_any_more(mapped: Bank) -> None:
    leases, before = Leases(None), len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        another = Bank.open(mapped.path)
        leases.hold(another)
        assert len(os.listdir("/proc/self/fd")) > before
        del another
        gc.collect()
    assert len(os.listdir("/proc/self/fd")) == before
    subprocess.run(["cp", "/dev/null", next(iter(mapped.files.values()))], check=True)  # would wait for 45 s


@contextmanager
def refused(bank: Bank, number: int) -> Iterator[str]:
    """Has the system refuse to lease one of a bank's files, and gives the file's name."""
    file = list(bank.files.values())[number]
    with file.open("r+b"):  # no file that is open for writing can be leased
        yield str(file)


def test_a_bank_of_which_one_table_cannot_be_leased_is_mapped_from_copies(
    mapped: Bank, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    leases, before = Leases(tmp_path / "copies"), len(os.listdir("/proc/self/fd"))
    with refused(mapped, -1) as file:
        held = leases.hold(mapped)
    (record,) = caplog.records
    assert record.message == "a bank is mapped from copies of its tables"
    assert file in vars(record)["detail"]
    assert len(os.listdir("/proc/self/fd")) == before + len(held.tables)  # each map has one; no lease is kept
    assert (held.path, held.digest, held.files) == (mapped.path, mapped.digest, mapped.files)
    for table in held.tables.values():
        assert isinstance(table.base, np.memmap)
        assert Path(str(table.base.filename)).is_relative_to(tmp_path / "copies")


def test_a_bank_that_can_be_neither_leased_nor_copied_is_logged_and_stays_mapped(
    mapped: Bank, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(_: object, sink: Path) -> None:
        sink.write_bytes(b"begun")
        raise OSError(errno.ENOSPC, "No space left on device", str(sink))

    monkeypatch.setattr(shutil, "copyfile", full)
    with refused(mapped, 0) as file:
        assert Leases(tmp_path / "copies").hold(mapped) is mapped
    (record,) = caplog.records
    assert record.message == "mapped tables are not protected from truncation"
    assert file in vars(record)["detail"]
    assert "No space left on device" in vars(record)["detail"]
    assert not [one for one in (tmp_path / "copies").rglob("*") if one.is_file() and one.stat().st_size]


def test_the_copy_of_a_bank_at_a_url_is_not_copied_again(mapped: Bank, caplog: pytest.LogCaptureFixture) -> None:
    copies = mapped.path.parent
    with refused(mapped, 0):
        assert Leases(copies).hold(mapped) is mapped
    assert "the bank is a copy already" in vars(caplog.records[0])["detail"]
    assert list(copies.iterdir()) == [mapped.path]


def test_a_table_that_cannot_be_kept_is_logged(
    mapped: Bank, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    leases = Leases(None)
    assert leases.hold(mapped) is mapped
    file = next(iter(mapped.files.values()))

    def full(_: object) -> None:
        raise OSError(12, "Cannot allocate memory")

    async def overwritten() -> None:
        task = asyncio.create_task(leases.keep(0.01))
        with pytest.raises(subprocess.TimeoutExpired):
            await asyncio.to_thread(lambda: subprocess.run(["cp", "/dev/null", file], timeout=0.5, check=True))
        task.cancel()

    monkeypatch.setattr(leasing, "move_into_memory", full)
    asyncio.run(overwritten())
    assert {record.message for record in caplog.records} == {
        "a table that is served is overwritten and could not be kept"
    }
    assert file.stat().st_size > 0
