"""One job at a time for a folder: two at once would remove each other's tables and cached results."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from motionsplice.precompute.job.outcome import Progress

LOCK = ".job.lock"
WAITING = "waiting"  # the stage, while another job works on the folder


@contextmanager
def alone_in(folder: Path, progress: Progress) -> Iterator[None]:
    """Holds the folder's lock, and first waits for a job that holds it. A job that is killed releases it."""
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        progress(WAITING, 0, 1)
        lock.acquire()
        progress(WAITING, 1, 1)
    try:
        yield
    finally:
        lock.release()
