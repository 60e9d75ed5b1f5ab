"""The offline job's progress, as a file that other programs read while it runs (docs/offline.md)."""

from __future__ import annotations

import json
import os
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionsplice.motion.errors import SettingsError

if TYPE_CHECKING:
    from motionsplice.precompute.job.outcome import Outcome

INTERVAL = 0.1  # seconds between two writes


class ProgressFile:
    """A JSON file that is replaced as a whole, so that a reader never sees half of it.

    It is written at once: else a job that is killed early would leave the result of the job before.
    Raises SettingsError if it cannot be written.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        self._written = 0.0
        self._write({"stage": "starting", "done": 0, "total": 0, "finished": False})

    def show(self, stage: str, done: int, total: int) -> None:
        """Writes how many of a stage's clips are done, at most every INTERVAL seconds."""
        if done == total or time.monotonic() - self._written >= INTERVAL:
            self._write({"stage": stage, "done": done, "total": total, "finished": False})
            self._written = time.monotonic()

    def finish(self, outcome: Outcome) -> None:
        """Writes the digest of the bank, and why clips failed."""
        failed = {name: str(error) for name, error in outcome.failed.items()}
        self._write({"finished": True, "bank": outcome.digest, "failed": failed})

    def fail(self, reason: str) -> None:
        """Writes why no bank was made."""
        self._write({"finished": True, "error": reason})

    def _write(self, fields: dict[str, Any]) -> None:
        fresh = self._file.with_name(f"{self._file.name}.{os.getpid()}")
        try:
            fresh.write_text(json.dumps(fields))
            os.replace(fresh, self._file)
        except OSError as error:
            with suppress(OSError):
                fresh.unlink()
            problem = f"the progress cannot be written: {error.strerror}"
            mend = "Name a file in a folder that you can write to"
            raise SettingsError(problem, file=str(self._file), mend=mend) from None
