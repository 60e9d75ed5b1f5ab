"""Runs the offline job on a folder of clips in its own process, when there is work, and reports its progress.

The work to do, what was tried and the progress are stored in the folder, so that a restarted service or another worker
reports the same.
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
MOST_OUTPUT = 2000  # characters of a job's output in the log
MOST_TRIES = 3  # times that the same work is started if the job ends early
INTERVAL = 0.3  # seconds between two checks of the folder
PATIENCE = 2.0  # seconds between two starts of the job
NICE = 10  # priority of the job: streams come first
NOT_IN_BANK = "the job finished, but the clip is not in the bank"
ENDED_EARLY = f"The offline job ended early {MOST_TRIES} times; see the service's log."

State = Literal["idle", "waiting", "running", "failed"]


class JobInfo(BaseModel):
    """The state and progress of the offline job."""

    state: State
    stage: str = Field(default="", description="stage that is running")
    done: int = Field(default=0, description="clips that the stage has done")
    total: int = Field(default=0, description="clips of the stage")
    clips: list[str] = Field(default=[], description="clips that are not in the bank yet")
    failed: dict[str, str] = Field(default={}, description="the reason for each clip that failed")
    error: str = Field(default="", description="the reason if the whole job failed")
    bank: str = Field(default="", description="digest of the bank on disk")


class Job:
    """The offline job of one folder of clips and the bank built from it."""

    def __init__(self, clips: Path, bank: Path) -> None:
        self._clips = clips
        self._bank = bank
        self._folder = Folder(clips, bank)
        self._changed = asyncio.Event()
        self._looking = asyncio.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self.info = JobInfo(state="idle")

    def ask(self) -> None:
        """Requests a run of the job even if no clip is pending, as a neutral may have changed."""
        (self._clips / ASKED).touch()

    async def look(self) -> JobInfo:
        """Returns the current state."""
        async with self._looking:
            info, _ = await asyncio.to_thread(self._look)
        self._set(info)
        return info

    async def run(self) -> None:
        """Starts the job whenever there is work, until cancelled. A running job continues after that."""
        last, logged = -PATIENCE, ""
        if _read(self._clips / PROGRESS).get("finished") is False:
            self.ask()  # it was killed or failed, and may succeed now
        while True:
            try:
                now = asyncio.get_running_loop().time()
                async with self._looking:
                    info, todo = await asyncio.to_thread(self._look)
                    if info.state == "waiting" and now - last >= PATIENCE:
                        if await asyncio.to_thread(self._start, todo):
                            info = info.model_copy(update={"state": "running"})
                        last = now
                self._set(info)
            except Exception as error:
                if repr(error) != logged:  # once, not at every check
                    logger.exception("the folder of clips could not be checked")
                    logged = repr(error)
            await asyncio.sleep(INTERVAL)

    async def changes(self, stopping: Callable[[], bool]) -> AsyncIterator[JobInfo | None]:
        """Yields the state now and at each change, and None after each second without one, until `stopping` is true."""
        known = None
        while not stopping():
            if self.info != known:
                known = self.info
                yield known
                continue
            waiting = self._changed
            try:
                async with asyncio.timeout(1.0):
                    await waiting.wait()
            except TimeoutError:
                yield None

    def _set(self, info: JobInfo) -> None:
        if info != self.info:
            self.info = info
            self._changed.set()
            self._changed = asyncio.Event()

    def _look(self) -> tuple[JobInfo, dict[str, str]]:
        """Returns the state, and the pending clips that have not failed already."""
        self._log_end()
        pending, progress, tried = self._folder.pending(), _read(self._clips / PROGRESS), _read(self._clips / TRIED)
        running, asked = self._is_running(), (self._clips / ASKED).exists()
        failed: dict[str, str] = {}
        error = ""
        failed_before: set[str] = set()
        if not running and not asked and tried:
            before, ended_early = tried.get("clips", {}), not progress.get("finished")
            if not ended_early or tried.get("times", 0) >= MOST_TRIES:
                failed_before = {name for name, what in pending.items() if before.get(name) == what}
            if failed_before:
                error = ENDED_EARLY if ended_early else progress.get("error", "")
                reasons = progress.get("failed", {})
                own = f"{self._clips}/"  # where the folder lies is no concern of clients
                failed = {name: reasons.get(name, NOT_IN_BANK).replace(own, "") for name in failed_before if not error}
                error = error.replace(own, "")
        todo = {name: what for name, what in pending.items() if name not in failed_before}
        state: State = "running" if running else "waiting" if todo or asked else "failed" if failed_before else "idle"
        if state == "waiting" and (missing := self._folder.missing()):
            state, error = "failed", _missing_clips(missing)
        shown = progress if running else {}
        info = JobInfo(
            state=state,
            stage=shown.get("stage", ""),
            done=shown.get("done", 0),
            total=shown.get("total", 0),
            clips=sorted(pending),
            failed=failed,
            error=error,
            bank=self._folder.manifest.digest if self._folder.manifest else "",
        )
        return info, todo

    def _log_end(self) -> None:
        """Logs the job's result, if this service started it and it has ended."""
        if self._process is None or (status := self._process.poll()) is None:
            return
        self._process, progress = None, _read(self._clips / PROGRESS)
        if not progress.get("finished"):
            output = (self._clips / OUTPUT).read_text(encoding="utf-8", errors="replace").strip()[-MOST_OUTPUT:]
            logger.error("the offline job ended early", extra={"status": status, "output": output})
        elif failed := progress.get("failed") or progress.get("error"):
            logger.warning("the offline job failed in part", extra={"failed": failed})
        else:
            logger.info("the offline job is done", extra={"bank": progress.get("bank", "")})

    def _is_running(self) -> bool:
        with (self._clips / LOCK).open("ab") as lock:
            return not _take(lock.fileno(), fcntl.LOCK_SH)  # shared, so that two checks at once both succeed

    def _start(self, todo: dict[str, str]) -> bool:
        """Starts the job, which holds the lock until it ends. Returns False if the job of another worker holds it."""
        with (self._clips / LOCK).open("ab") as lock:
            if not _take(lock.fileno(), fcntl.LOCK_EX):
                return False
            asked, tried, pending = self._clips / ASKED, _read(self._clips / TRIED), self._folder.pending()
            again = not asked.exists() and tried.get("clips") == pending
            asked.unlink(missing_ok=True)
            _write(self._clips / TRIED, {"clips": pending, "times": tried.get("times", 0) * again + 1})
            _write(self._clips / PROGRESS, {"stage": "starting", "finished": False})
            command = [sys.executable, "-m", "motionsplice", "precompute", str(self._clips), "--out", str(self._bank)]
            command += [*self._as_before(), "--progress", str(self._clips / PROGRESS)]
            with (self._clips / OUTPUT).open("wb") as output:
                self._process = subprocess.Popen(
                    command,
                    pass_fds=(lock.fileno(),),
                    start_new_session=True,  # signals that end the service do not end it
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                )
            os.setpriority(os.PRIO_PROCESS, self._process.pid, NICE)
        logger.info("the offline job is started", extra={"clips": sorted(todo)})
        return True

    def _as_before(self) -> list[str]:
        """Returns the options for the current bank's baseline and skeleton, so that its clips stay aligned to them."""
        if self._folder.manifest is None:
            return []
        return ["--baseline", self._folder.manifest.baseline.clip, "--skeleton", str(self._bank)]


def _missing_clips(missing: list[str]) -> str:
    """Returns why no job is started: the new bank would lose the clips that are not in the folder."""
    named = ", ".join(missing[:10]) + (f" and {len(missing) - 10} more" if len(missing) > 10 else "")
    mend = "Copy their files there, or build the bank without them with `motionsplice precompute`"
    return str(MotionError(f"the folder does not have these clips of the bank: {named}", mend=mend))


def _take(descriptor: int, kind: int) -> bool:
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _read(file: Path) -> dict[str, Any]:
    try:
        document = orjson.loads(file.read_bytes())
    except (OSError, orjson.JSONDecodeError):
        return {}
    return document if isinstance(document, dict) else {}


def _write(file: Path, document: dict[str, Any]) -> None:
    fresh = file.with_suffix(f".{os.getpid()}.new")
    fresh.write_bytes(orjson.dumps(document))
    os.replace(fresh, file)
