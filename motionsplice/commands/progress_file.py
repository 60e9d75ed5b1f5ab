"""The offline job's progress, as a file that other programs read while it runs (docs/offline.md)."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motionsplice.precompute.job.outcome import Outcome

INTERVAL = 0.1  # seconds between two writes


class ProgressFile:
    """A JSON file that is replaced as a whole, so that a reader never sees half of it."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._written = 0.0

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
        fresh.write_text(json.dumps(fields))
        os.replace(fresh, self._file)
