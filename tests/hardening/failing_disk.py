"""Disks that fail: `python -m tests.hardening.failing_disk`.

A job replaces a bank, and one of its operations on files fails: each that opens, creates, writes, syncs, renames,
removes or makes a folder, one by one, with each of ENOSPC, EIO and EACCES; and a first bank is made likewise. The job
must end or raise a typed error; the bank must be the old or the new one, whole; another run must leave what an
undisturbed job does. Prints how many failures were tried, and exits with 1 at a wrong one.
"""

from __future__ import annotations

import errno
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import get_args

import typer

from motionsplice.cli import run
from motionsplice.motion.errors import MotionError
from tests.hardening.disk import Disk, Kind, recorded
from tests.hardening.memory import IN_MEMORY
from tests.hardening.replacement import DisturbedError, Replacement

ERRORS = (errno.ENOSPC, errno.EIO, errno.EACCES)


def check(replacement: Replacement, place: Path, errors: Sequence[int], every: int = 1) -> int:
    """Lets every `every`-th operation fail with each of the errors. Returns how many. Raises DisturbedError."""
    count = 0
    for kind in get_args(Kind):
        for error in errors:
            at, fails = 1, True
            while fails:
                fails = _fails(replacement, place, kind, at, error)
                at, count = at + every, count + fails
    return count


def _fails(replacement: Replacement, place: Path, kind: Kind, at: int, error: int) -> bool:
    """Lets one operation fail. Returns whether there was one."""
    replacement.begin(place)
    with recorded(Disk(place, kind, at, error)) as disk:
        try:
            replacement.run(place)
        except MotionError as refused:
            str(refused).encode()
        except Exception as raw:
            raise DisturbedError(f"{kind} {at} failed with {errno.errorcode[error]}: untyped {raw!r}") from raw
    if disk.failed:
        try:
            replacement.check_whole(place)
            replacement.check_rerun(place)
        except DisturbedError as wrong:
            raise DisturbedError(f"{kind} {at} failed with {errno.errorcode[error]}: {wrong}") from None
    return disk.failed


def main() -> None:
    """Checks replacing a bank, and making one where there was none."""
    for afresh in (False, True):
        with tempfile.TemporaryDirectory(dir=IN_MEMORY) as name:
            replacement = Replacement.make(Path(name) / "made", afresh=afresh)
            count = check(replacement, Path(name) / "bank", ERRORS)
        print(f"{'first' if afresh else 'another'} bank: {count} operations failed; the old or the new bank was left")


if __name__ == "__main__":
    run(lambda: typer.run(main))
