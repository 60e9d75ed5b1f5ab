"""Jobs that are killed: `python -m tests.hardening.killed [--kills 500] [--seed 0]`.

A job that replaces a bank by another is killed (`kill -9`) at a random moment of the time that it takes. The bank must
be the old or the new one, whole; another run must leave what an undisturbed job does, and nothing of the killed one.
Prints how many jobs left which bank, and exits with 1 at a wrong one.
"""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections import Counter
from multiprocessing import get_context
from pathlib import Path
from random import Random
from typing import Annotated

import typer

from motionsplice.cli import run
from tests.hardening.memory import IN_MEMORY
from tests.hardening.replacement import DisturbedError, Replacement

TIMED = 3  # undisturbed jobs; the moments lie within the time of the middle one
FORK = get_context("fork")  # a job begins with all that is imported and compiled


def check(replacement: Replacement, place: Path, kills: int, seed: int) -> Counter[str]:
    """Kills this many jobs. Returns how many left which bank, or had ended. Raises DisturbedError."""
    draw, found = Random(seed), Counter[str]()
    durations = []
    for _ in range(TIMED):
        replacement.begin(place)
        durations.append(_run(replacement, place, None))
    replacement.begin(place)
    old, duration = replacement.check_whole(place), sorted(durations)[TIMED // 2]
    for kill in range(kills):
        replacement.begin(place)
        moment = draw.uniform(0.0, duration)
        ended = _run(replacement, place, moment) < moment
        try:
            bank = replacement.check_whole(place)
            replacement.check_rerun(place)
        except DisturbedError as wrong:
            raise DisturbedError(f"kill {kill}, after {moment * 1e3:.1f} ms: {wrong}") from None
        found["ended before" if ended else "old bank" if bank == old else "new bank"] += 1
    return found


def _run(replacement: Replacement, place: Path, moment: float | None) -> float:
    """Runs a job in a process of its own, and kills it at a moment, in seconds. Returns how long it ran."""
    job = FORK.Process(target=replacement.run, args=(place,))
    job.start()
    began = time.perf_counter()
    job.join(moment)
    if job.is_alive():
        assert job.pid is not None
        os.kill(job.pid, signal.SIGKILL)
        job.join()
        return float("inf")
    return time.perf_counter() - began


def main(
    kills: Annotated[int, typer.Option(min=1, help="Number of jobs that are killed")] = 500,
    seed: Annotated[int, typer.Option(help="Number from which the moments are drawn")] = 0,
) -> None:
    """Kills jobs."""
    with tempfile.TemporaryDirectory(dir=IN_MEMORY) as name:
        replacement = Replacement.make(Path(name) / "made")
        found = check(replacement, Path(name) / "bank", kills, seed)
    print(f"{kills} jobs killed: {', '.join(f'{count} {what}' for what, count in sorted(found.items()))}")


if __name__ == "__main__":
    run(lambda: typer.run(main))
