"""The offline job run by the service: started, killed, failing, reported."""

from __future__ import annotations

import asyncio
import fcntl
import logging
import shutil
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path

import orjson
import pytest

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.runtime.bank import Bank
from motionsplice.service.exchange import job as jobs
from motionsplice.service.exchange.job import LOCK, MOST_TRIES, Job, JobInfo
from tests.service.running import PATIENCE


@pytest.fixture
def folder(clip_folder: Path, bank: Bank, tmp_path: Path) -> Path:
    """A folder of clips beside a bank of all but one of them."""
    shutil.copytree(clip_folder, tmp_path / "clips")
    shutil.copytree(bank.path, tmp_path / "bank")
    (tmp_path / "clips" / "jog.bvh").write_bytes(dump_bvh(make("run", seed=20, seconds=3.0)))
    return tmp_path / "clips"


def job_of(folder: Path) -> Job:
    return Job(folder, folder.parent / "bank")


async def until(job: Job, holds: Callable[[JobInfo], bool]) -> JobInfo:
    async with asyncio.timeout(2 * PATIENCE):
        while not holds(info := await job.look()):
            await asyncio.sleep(0.01)
    return info


def while_running(folder: Path, what: Callable[[Job], Awaitable[JobInfo]]) -> JobInfo:
    """Returns the result of `what`, called while a service runs the job of a folder."""

    async def both() -> JobInfo:
        job = job_of(folder)
        runs = asyncio.create_task(job.run())
        try:
            return await what(job)
        finally:
            runs.cancel()

    return asyncio.run(both())


def fake_job(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """Replaces the offline job by a shell script."""
    program = folder.parent / "job.sh"
    program.write_text(f"#!/bin/sh\necho x >> {folder.parent}/starts\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    monkeypatch.setattr(jobs, "PATIENCE", 0.0)
    monkeypatch.setattr(jobs, "INTERVAL", 0.01)


def starts(folder: Path) -> int:
    return len((folder.parent / "starts").read_text().split())


def test_two_checks_at_once_do_not_see_each_other_as_the_job(folder: Path) -> None:
    job, another = job_of(folder), job_of(folder)
    with (folder / LOCK).open("ab") as lock:
        assert jobs._take(lock.fileno(), fcntl.LOCK_SH)
        assert not job._is_running()
        assert not another._is_running()
        assert jobs._take(lock.fileno(), fcntl.LOCK_EX)
        assert job._is_running()


def test_a_job_that_always_ends_early_is_not_started_for_ever(
    folder: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    fake_job(folder, monkeypatch, "echo the disk is full >&2; exit 3")

    async def wait(job: Job) -> JobInfo:
        info = await until(job, lambda info: info.state == "failed")
        await asyncio.sleep(0.2)  # long enough to start it again
        return info

    with caplog.at_level(logging.ERROR):
        info = while_running(folder, wait)
    assert starts(folder) == MOST_TRIES
    assert (info.clips, info.failed) == (["jog"], {})
    assert "ended early 3 times" in info.error
    assert [(one.status, one.output) for one in caplog.records] == [(3, "the disk is full")] * MOST_TRIES  # type: ignore[attr-defined]
    while_running(folder, wait)  # another service tries again, as often
    assert starts(folder) == 2 * MOST_TRIES
    (folder / "jog.bvh").write_bytes(b"HIERARCHY")
    while_running(folder, lambda job: until(job, lambda info: info.state != "failed"))


def test_a_job_that_fails_as_a_whole_is_reported(folder: Path) -> None:
    (folder / "clips.toml").write_text("[nobody]\nkind = 'action'\n")
    info = while_running(folder, lambda job: until(job, lambda info: info.state == "failed"))
    assert info.error.startswith("clips.toml: clip 'nobody' not found")  # and not where the folder is
    assert (info.clips, info.failed) == (["carry_box", "jog", "wave"], {})


def test_no_clip_of_the_bank_is_lost(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "run.bvh").unlink()
    (folder.parent / "starts").touch()
    fake_job(folder, monkeypatch, "exit 0")
    info = while_running(folder, lambda job: until(job, lambda info: info.state == "failed"))
    assert "the folder does not have these clips of the bank: run. " in info.error
    assert starts(folder) == 0


def test_the_first_answer_is_up_to_date(folder: Path) -> None:
    async def first() -> JobInfo:
        return await job_of(folder).look()

    info = asyncio.run(first())
    assert (info.state, info.clips) == ("waiting", ["jog"])


def test_a_job_continues_without_the_service_and_is_reported_by_the_next(folder: Path, bank: Bank) -> None:
    while_running(folder, lambda job: until(job, lambda info: info.state == "running"))
    info = while_running(folder, lambda job: until(job, lambda info: info.state == "idle"))
    assert (info.clips, info.failed, info.error) == ([], {}, "")
    assert info.bank == Bank.open(folder.parent / "bank").digest != bank.digest
    assert orjson.loads((folder / jobs.TRIED).read_bytes())["times"] == 1
