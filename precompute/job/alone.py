"""One job at a time for a folder: two at once would remove each other's tables and cached results."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from motionsplice.precompute.job.outcome import Progress
from motionsplice.precompute.job.written import make_folder, written

LOCK = ".job.lock"
WAITING = "waiting"  # the stage, while another job works on the folder


@contextmanager
def alone_in(folder: Path, progress: Progress) -> Iterator[None]:
    """Holds the folder's lock, and first waits for a job that holds it. A job that is killed releases it.

    Raises BankError if the folder cannot be written.
    """
    make_folder(folder)
    lock = FileLock(folder / LOCK)
    with written(folder):
        waits = not _got_at_once(lock)
    if waits:
        progress(WAITING, 0, 1)
        with written(folder):
            lock.acquire()
        progress(WAITING, 1, 1)
    try:
        yield
    finally:
        lock.release()


def _got_at_once(lock: FileLock) -> bool:
    try:
        lock.acquire(timeout=0)
    except Timeout:
        return False
    return True
