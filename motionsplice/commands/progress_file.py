"""How far the offline job is, as a file that others read while it runs (docs/offline.md)."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

from motionsplice.precompute.job.outcome import Outcome

INTERVAL = 0.1  # seconds between two writes


class ProgressFile:
    """Is replaced as a whole, so that a reader never sees a part of it."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._written = 0.0

    def show(self, stage: str, done: int, total: int) -> None:
        """Tells how many of a stage's clips are done."""
        if done == total or time.monotonic() - self._written >= INTERVAL:
            self._write({"stage": stage, "done": done, "total": total, "finished": False})
            self._written = time.monotonic()

    def finish(self, outcome: Outcome) -> None:
        """Tells what was made, and why clips failed."""
        failed = {name: str(error) for name, error in outcome.failed.items()}
        self._write({"finished": True, "bank": outcome.digest, "failed": failed})

    def give_up(self, reason: str) -> None:
        """Tells why nothing was made."""
        self._write({"finished": True, "error": reason})

    def _write(self, told: dict[str, Any]) -> None:
        fresh = self._file.with_name(f"{self._file.name}.{os.getpid()}")
        fresh.write_text(json.dumps(told))
        os.replace(fresh, self._file)
