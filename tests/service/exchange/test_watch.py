from __future__ import annotations

import asyncio
import errno
import os
import shutil
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from bench.service.banks import put
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime import bank as opening
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import clock_kernels
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.format import tables
from motionsplice.runtime.format.manifest import MANIFEST
from motionsplice.runtime.splice import Splice
from motionsplice.service.exchange import leases as leasing
from motionsplice.service.exchange import watch as watching
from motionsplice.service.exchange.leases import Leases
from motionsplice.service.metrics import Metrics
from motionsplice.service.serving import Edition, Serving
from motionsplice.service.settings import Settings
from tests.service.characters.player import Player
from tests.service.running import PATIENCE, Running, eventually, running


@pytest.fixture(scope="module")
def other(clip_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """A bank with a longer run and without the side-step."""
    clips = tmp_path_factory.mktemp("other") / "clips"
    shutil.copytree(clip_folder, clips)
    (clips / "run.bvh").write_bytes(dump_bvh(make("run", seed=12, seconds=4.0)))
    (clips / "side_step.bvh").unlink()
    build_bank([clips], clips.parent / "bank", baseline="walk", jobs=1)
    return Bank.open(clips.parent / "bank")


@pytest.fixture
def place(bank: Bank, tmp_path: Path) -> Path:
    """A copy of the bank, which tests overwrite."""
    shutil.copytree(bank.path, tmp_path / "bank", ignore=shutil.ignore_patterns("cache"))
    return tmp_path / "bank"


@pytest.fixture
def service(place: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Running]:
    monkeypatch.setattr(watching, "INTERVAL", 0.05)
    monkeypatch.setattr(watching.watch, "__defaults__", (0.05,))
    with running(place, Settings(watch=True)) as service:
        yield service


def served(service: Running) -> str:
    return service.config.front.shared.serving.bank.digest


def refusals(service: Running) -> float:
    return float(service.config.front.shared.metrics.exchanges.labels("refused")._value.get())


def test_a_new_bank_is_served_and_connections_move_to_it(
    service: Running, bank: Bank, other: Bank, place: Path
) -> None:
    with Player(service) as mover, Player(service) as stayer:
        mover.do({"do": "create", "id": 1, "locomotion": "run"})
        stayer.do({"do": "create", "id": 1, "locomotion": "side_step"})
        put(other.path, place)
        moved = mover.event("bank")
        assert moved["bank"] == other.digest
        frames = mover.frames_until(moved["frame"] + 2)
        numbers = [frame["frame"] for frame in frames]
        assert numbers == sorted(set(numbers))  # a slow machine skips some
        assert {frame["bank"] for frame in frames if frame["frame"] < moved["frame"]} <= {bank.digest}
        assert {frame["bank"] for frame in frames if frame["frame"] >= moved["frame"]} == {other.digest}
        event = stayer.event("bank_kept")
        assert (event["bank"], event["missing"]) == (other.digest, ["side_step"])
        stayer.frames.clear()
        assert stayer.frame()["bank"] == bank.digest
        assert stayer.do({"do": "play", "id": 1, "locomotion": "walk"})["event"] == "done"
        assert stayer.event("bank")["bank"] == other.digest
    with Player(service) as late:
        assert late.welcome["bank"] == other.digest


@pytest.mark.parametrize("damage", ["manifest cut short", "table altered", "table missing", "manifest missing"])
def test_a_damaged_bank_is_refused_and_the_old_one_stays_in_service(
    service: Running, bank: Bank, other: Bank, place: Path, damage: str, tmp_path: Path
) -> None:
    broken = tmp_path / "broken"
    shutil.copytree(other.path, broken, ignore=shutil.ignore_patterns("cache"))
    table = broken / "tables" / f"{other.manifest.tables['phase_of_frame']}.npy"
    if damage == "manifest cut short":
        (broken / MANIFEST).write_bytes((broken / MANIFEST).read_bytes()[:-9])
    elif damage == "table altered":
        table.write_bytes(table.read_bytes()[:-8] + bytes(8))
    elif damage == "table missing":
        table.unlink()
    with Player(service) as player:
        player.do({"do": "create", "id": 1, "locomotion": "run"})
        if damage == "manifest missing":
            (place / MANIFEST).unlink()
        else:
            put(broken, place)
        eventually(lambda: refusals(service) == 1)
        player.frames.clear()
        assert player.frame()["bank"] == served(service) == bank.digest
        put(other.path, place)
        for file in (other.path / "tables").iterdir():
            shutil.copy(file, place / "tables" / file.name)
        (place / MANIFEST).touch()
        assert player.event("bank")["bank"] == other.digest


def test_a_bank_that_cannot_be_read_for_a_while_is_served_later(
    service: Running, other: Bank, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused = refusals(service)
    with monkeypatch.context() as exhausted:

        def open_none(files: object) -> None:
            raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

        exhausted.setattr(opening, "open_tables", open_none)
        put(other.path, place)
        eventually(lambda: refusals(service) > refused)
    eventually(lambda: served(service) == other.digest)


def test_the_kernel_that_moves_characters_to_a_bank_is_compiled_before_the_bank_is_served(
    bank: Bank, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel, called = clock_kernels.recompute_from_frames, list[int]()

    def noted(*arguments: object) -> None:
        called.append(len(arguments))
        kernel(*arguments)

    monkeypatch.setattr(clock_kernels, "recompute_from_frames", noted)
    Edition.warm(bank)
    assert called


def test_twenty_exchanges_tear_no_frame(service: Running, bank: Bank, other: Bank, place: Path) -> None:
    evaluators = {one.digest: Evaluator(one) for one in (bank, other)}
    with Player(service, "?rate=120") as player:
        player.do({"do": "create", "id": 1, "locomotion": "run"}, {"do": "speed", "id": 1, "speed": 0.0})
        for number in range(20):
            new = (other, bank)[number % 2]
            put(new.path, place)
            assert player.event("bank")["bank"] == new.digest
        frames = player.frames
    numbers = [frame["frame"] for frame in frames]
    assert numbers == sorted(set(numbers))  # a slow machine skips some
    for digest, evaluator in evaluators.items():
        wanted = evaluator.pose(Splice("run"), 0.0).rotations[0, 1:]  # without the root, which has the heading
        some = [frame["rotations"][0, 0, 1:] for frame in frames if frame["bank"] == digest]
        assert len(some) > 5
        assert all(abs(one - wanted).max() < 1e-6 for one in some)


def test_banks_that_cannot_be_leased_are_served_from_copies(
    bank: Bank, other: Bank, place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(_: Bank, __: str) -> None:
        raise OSError(errno.EACCES, "Permission denied")

    def mapped(evaluated: Bank) -> set[Path]:
        return {Path(str(table.base.filename)).parent for table in evaluated.tables.values()}  # type: ignore[union-attr]

    monkeypatch.setattr(leasing, "_leased", refused)
    monkeypatch.setattr(tables, "SMALL", 0)
    monkeypatch.setattr(watching.watch, "__defaults__", (0.05,))
    with running(place, Settings(watch=True, copies=tmp_path / "copies")) as service:
        serving = service.config.front.shared.serving
        assert serving.edition.bank.digest == bank.digest
        (folder,) = mapped(serving.edition.bank)
        assert folder.is_relative_to(tmp_path / "copies")
        put(other.path, place)
        eventually(lambda: served(service) == other.digest)
        assert mapped(serving.edition.bank) == {folder}
        assert {file.stem for file in folder.iterdir()} == set(other.manifest.tables.values())


def test_a_bank_that_was_written_while_the_service_started_is_served(bank: Bank, other: Bank, place: Path) -> None:
    opened = Bank.open(place)
    put(other.path, place)

    async def start() -> str:
        serving = Serving(opened)
        await serving.warm()
        watches = asyncio.create_task(watching.watch(serving, Metrics(), Leases(None), 0.01))
        async with asyncio.timeout(PATIENCE):
            while serving.bank.digest == bank.digest:
                await asyncio.sleep(0.01)
        watches.cancel()
        return serving.bank.digest

    assert asyncio.run(start()) == other.digest


def test_a_service_that_stops_does_not_wait_for_the_verification_of_a_bank(
    bank: Bank, other: Bank, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, may_end, ended = threading.Event(), threading.Event(), threading.Event()

    def slowly(_: Bank) -> None:
        begun.set()
        may_end.wait(PATIENCE)
        ended.set()

    monkeypatch.setattr(Bank, "verify", slowly)

    async def stop() -> None:
        serving = Serving(bank)
        serving.exchange(Edition.warm(bank))
        put(other.path, place)
        serving.bank = replace(bank, path=place)
        watches = asyncio.create_task(watching.watch(serving, Metrics(), Leases(None), 0.01))
        await asyncio.to_thread(begun.wait, PATIENCE)
        watches.cancel()

    asyncio.run(stop())
    assert begun.is_set()
    assert not ended.is_set()
    may_end.set()
