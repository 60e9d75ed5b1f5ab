"""The offline job of a folder of clips, as a process of its own: started when there is work, and asked how far it is.

What is to be done, what was tried and how far it is lies in the folder, so a service that was restarted, or another
worker, tells the same.
"""

from __future__ import annotations

import asyncio
import fcntl
import logging
import os
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any, Literal

import orjson
from pydantic import BaseModel, Field

from motionsplice.motion.errors import MotionError
from motionsplice.service.exchange.pending import Folder

logger = logging.getLogger(__name__)

LOCK, ASKED, TRIED, PROGRESS = ".job.lock", ".job-asked", ".job-tried.json", ".job-progress.json"
OUTPUT = ".job-output.txt"
MOST_TOLD = 2000  # characters of a job's output that the log gets
MOST_TRIES = 3  # of one and the same work, by a job that ends before it is done
INTERVAL = 0.3  # seconds between two looks
PATIENCE = 2.0  # seconds before a job that was killed is started again
NICE = 10  # streams come first
NOT_THERE = "it is not in the bank"
ENDED_EARLY = f"The offline job ended {MOST_TRIES} times before it was done; the service's log says how."

State = Literal["idle", "waiting", "running", "failed"]


class JobInfo(BaseModel):
    """How far the offline job is."""

    state: State
    stage: str = Field(default="", description="what is being done")
    done: int = 0
    total: int = 0
    clips: list[str] = Field(default=[], description="clips that are not in the bank yet")
    failed: dict[str, str] = Field(default={}, description="why each clip that failed did")
    error: str = Field(default="", description="why the job as a whole failed")
    bank: str = Field(default="", description="digest of the bank on disk")


class Job:
    """The job of one folder of clips and the bank made from it."""

    def __init__(self, clips: Path, bank: Path) -> None:
        self._clips = clips
        self._bank = bank
        self._folder = Folder(clips, bank)
        self._changed = asyncio.Event()
        self._looking = asyncio.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self.info = JobInfo(state="idle")

    def ask(self) -> None:
        """Has the job look at the folder again, whatever it looks like from here: a neutral may have changed."""
        (self._clips / ASKED).touch()

    async def look(self) -> JobInfo:
        """The state as it is now."""
        async with self._looking:
            info, _ = await asyncio.to_thread(self._look)
        self._tell(info)
        return info

    async def run(self) -> None:
        """Starts the job whenever there is work, for as long as the service lives. The job itself lives on."""
        last, told = -PATIENCE, ""
        if _read(self._clips / PROGRESS).get("finished") is False:
            self.ask()  # it was killed, or could not do its work: perhaps it can now
        while True:
            try:
                now = asyncio.get_running_loop().time()
                async with self._looking:
                    info, todo = await asyncio.to_thread(self._look)
                    if info.state == "waiting" and now - last >= PATIENCE:
                        if await asyncio.to_thread(self._start, todo):
                            info = info.model_copy(update={"state": "running"})
                        last = now
                self._tell(info)
            except Exception as error:
                if repr(error) != told:  # once, not at every look
                    logger.exception("the folder of clips could not be looked at")
                    told = repr(error)
            await asyncio.sleep(INTERVAL)

    async def changes(self, stopping: Callable[[], bool]) -> AsyncIterator[JobInfo | None]:
        """The state now and whenever it changes, and None after each second without a change, until the stop."""
        told = None
        while not stopping():
            if self.info != told:
                told = self.info
                yield told
                continue
            waiting = self._changed
            try:
                async with asyncio.timeout(1.0):
                    await waiting.wait()
            except TimeoutError:
                yield None

    def _tell(self, info: JobInfo) -> None:
        if info != self.info:
            self.info = info
            self._changed.set()
            self._changed = asyncio.Event()

    def _look(self) -> tuple[JobInfo, dict[str, str]]:
        """What is going on, and what is to be done that was not tried in vain."""
        self._hear()
        pending, progress, tried = self._folder.pending(), _read(self._clips / PROGRESS), _read(self._clips / TRIED)
        running, asked = self._is_running(), (self._clips / ASKED).exists()
        failed: dict[str, str] = {}
        error = ""
        in_vain: set[str] = set()
        if not running and not asked and tried:
            before, ended_early = tried.get("clips", {}), not progress.get("finished")
            if not ended_early or tried.get("times", 0) >= MOST_TRIES:
                in_vain = {name for name, what in pending.items() if before.get(name) == what}
            if in_vain:
                error = ENDED_EARLY if ended_early else progress.get("error", "")
                reasons = progress.get("failed", {})
                failed = {name: reasons.get(name, NOT_THERE) for name in in_vain if not error}
        todo = {name: what for name, what in pending.items() if name not in in_vain}
        state: State = "running" if running else "waiting" if todo or asked else "failed" if in_vain else "idle"
        if state == "waiting" and (missing := self._folder.missing()):
            state, error = "failed", _lacking(missing)
        seen = progress if running else {}
        info = JobInfo(
            state=state,
            stage=seen.get("stage", ""),
            done=seen.get("done", 0),
            total=seen.get("total", 0),
            clips=sorted(pending),
            failed=failed,
            error=error,
            bank=self._folder.manifest.digest if self._folder.manifest else "",
        )
        return info, todo

    def _hear(self) -> None:
        """Logs what came of the job, if this service started it and it has ended."""
        if self._process is None or (status := self._process.poll()) is None:
            return
        self._process, progress = None, _read(self._clips / PROGRESS)
        if not progress.get("finished"):
            said = (self._clips / OUTPUT).read_text(encoding="utf-8", errors="replace").strip()[-MOST_TOLD:]
            logger.error("the offline job ended before it was done", extra={"status": status, "output": said})
        elif failed := progress.get("failed") or progress.get("error"):
            logger.warning("the offline job could not do all", extra={"failed": failed})
        else:
            logger.info("the offline job is done", extra={"bank": progress.get("bank", "")})

    def _is_running(self) -> bool:
        with (self._clips / LOCK).open("ab") as lock:
            return not _take(lock.fileno(), fcntl.LOCK_SH)  # shared, so that two who ask do not take each other for it

    def _start(self, todo: dict[str, str]) -> bool:
        """Starts the job, which holds the lock until it ends; False if another worker's holds it."""
        with (self._clips / LOCK).open("ab") as lock:
            if not _take(lock.fileno(), fcntl.LOCK_EX):
                return False
            asked, tried, pending = self._clips / ASKED, _read(self._clips / TRIED), self._folder.pending()
            again = not asked.exists() and tried.get("clips") == pending
            asked.unlink(missing_ok=True)
            _write(self._clips / TRIED, {"clips": pending, "times": tried.get("times", 0) * again + 1})
            _write(self._clips / PROGRESS, {"stage": "starting", "finished": False})
            command = [sys.executable, "-m", "motionsplice", "precompute", str(self._clips), "--out", str(self._bank)]
            command += ["--baseline", self._baseline(), "--progress", str(self._clips / PROGRESS)]
            with (self._clips / OUTPUT).open("wb") as output:
                self._process = subprocess.Popen(
                    command,
                    pass_fds=(lock.fileno(),),
                    start_new_session=True,  # it is not ended by what ends the service
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                )
            os.setpriority(os.PRIO_PROCESS, self._process.pid, NICE)
        logger.info("the offline job is started", extra={"clips": sorted(todo)})
        return True

    def _baseline(self) -> str:
        """The present bank's, so that its clips need not be aligned again."""
        return self._folder.manifest.baseline.clip if self._folder.manifest else "auto"


def _lacking(missing: list[str]) -> str:
    """Why no job is started: it makes the bank of what is in the folder, and clips would be lost."""
    named = ", ".join(missing[:10]) + (f" and {len(missing) - 10} more" if len(missing) > 10 else "")
    mend = "Put their files there, or build the bank without them with `motionsplice precompute`"
    return str(MotionError(f"the folder of clips lacks clips of the bank: {named}", mend=mend))


def _take(descriptor: int, kind: int) -> bool:
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _read(file: Path) -> dict[str, Any]:
    try:
        told = orjson.loads(file.read_bytes())
    except (OSError, orjson.JSONDecodeError):
        return {}
    return told if isinstance(told, dict) else {}


def _write(file: Path, told: dict[str, Any]) -> None:
    fresh = file.with_suffix(f".{os.getpid()}.new")
    fresh.write_bytes(orjson.dumps(told))
    os.replace(fresh, file)
