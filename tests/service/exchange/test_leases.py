from __future__ import annotations

import asyncio
import fcntl
import gc
import os
import shutil
import signal
import subprocess
import sys
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
import asyncio, subprocess, sys
import numpy as np
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format import tables
from motionsplice.service.exchange.leases import Leases

whole, place, held = Bank.open(sys.argv[1]), sys.argv[2], sys.argv[3] == "held"
tables.SMALL = 0
bank, leases = Bank.open(place), Leases()
if held:
    leases.hold(bank)

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


@pytest.mark.parametrize(("held", "status"), [("held", 0), ("not held", -signal.SIGBUS)])
def test_mapped_tables_that_are_leased_survive_that_their_files_are_overwritten(
    bank: Bank, place: Path, held: str, status: int
) -> None:
    project = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    command = [sys.executable, "-c", OVERWRITTEN, str(bank.path), str(place), held]
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
    leases, before = Leases(), len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        another = Bank.open(mapped.path)
        leases.hold(another)
        assert len(os.listdir("/proc/self/fd")) > before
        del another
        gc.collect()
    assert len(os.listdir("/proc/self/fd")) == before
    subprocess.run(["cp", "/dev/null", next(iter(mapped.files.values()))], check=True)  # would wait for 45 s


def test_what_cannot_be_leased_or_copied_is_logged(
    mapped: Bank, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    leases = Leases()
    files = list(mapped.files.values())
    with files[0].open("r+b"):  # no file that is open for writing can be leased
        leases.hold(mapped)
    (refused,) = caplog.records
    assert refused.message == "a mapped table is not protected from truncation"
    assert str(files[0]) in vars(refused)["detail"]
    caplog.clear()

    def full(_: object) -> None:
        raise OSError(12, "Cannot allocate memory")

    async def overwritten() -> None:
        task = asyncio.create_task(leases.keep(0.01))
        with pytest.raises(subprocess.TimeoutExpired):
            await asyncio.to_thread(lambda: subprocess.run(["cp", "/dev/null", files[1]], timeout=0.5, check=True))
        task.cancel()

    monkeypatch.setattr(leasing, "move_into_memory", full)
    asyncio.run(overwritten())
    assert {record.message for record in caplog.records} == {
        "a table that is served is overwritten and could not be kept"
    }
    assert files[1].stat().st_size > 0
