"""Measures the memory of a bank and the time to open it: `python -m bench.speed.memory [--clips 1000] [--seconds 36]`.

The bank is generated, by default of about 1 GB. Prints:
- the time to open it without and with verification, next to reading the same number of bytes and digesting them;
- the pages that two processes hold while both evaluate splices all over the bank (`/proc/PID/smaps`, Linux only);
- the bytes of a character's state.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import re
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.generated import Size, generate
from bench.speed.workload import RATE, Scene, request_sets
from motionsplice.cli import run
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import REQUEST, Memory

FIELDS = ("Size", "Rss", "Pss", "Shared_Clean", "Private_Clean", "Private_Dirty")
HEADING = re.compile(r"^[0-9a-f]+-[0-9a-f]+ ")
PROCESSES = 2


@dataclass(frozen=True)
class Opening:
    """Seconds to open a bank of `bytes`: medians, and the slowest without verification.

    reading, digesting: seconds to sum and to digest the same number of bytes in memory, for comparison.
    """

    bytes: int
    clips: int
    unverified: float
    slowest_unverified: float
    verified: float
    reading: float
    digesting: float


@dataclass(frozen=True)
class State:
    """Bytes per character: request and memory persist between frames; each frame overwrites the pose."""

    request: int
    memory: int
    pose: int


def main(
    clips: Annotated[int, typer.Option(min=1, help="Clips of the generated bank")] = 1000,
    seconds: Annotated[float, typer.Option(min=3.0, help="Length of each clip")] = 36.0,
    times: Annotated[int, typer.Option(min=1, help="How often to open the bank")] = 20,
    out: Annotated[Path | None, typer.Option(help="JSON file for the results")] = None,
) -> None:
    """Prints the time to open a large bank and the memory to hold it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bank"
        bank = generate(path, Size(clips=clips, seconds=seconds))
        for file in path.rglob("*.*"):
            with file.open("rb+") as written:
                os.fsync(written.fileno())  # otherwise pages not yet on disk would count as dirty
        opening, state = time_opening(bank, times), state_of(bank)
        del bank  # otherwise this process would share the pages too
        held = held_by_processes(path)
    show(opening, state, held)
    if out:
        document = {"opening": asdict(opening), "state": asdict(state), "processes": held}
        out.write_text(json.dumps(document, indent=1))


def time_opening(bank: Bank, times: int) -> Opening:
    """Opens a bank `times` times, with its files in the page cache."""
    data = np.ones(sum(table.nbytes for table in bank.tables.values()), np.uint8)
    unverified = seconds_of(lambda: Bank.open(bank.path, verify=False), times)
    verified = seconds_of(lambda: Bank.open(bank.path), 3)
    reading = seconds_of(lambda: data[: len(data) // 8 * 8].view(np.int64).sum(), 3)
    digesting = seconds_of(lambda: hashlib.blake2b(data.data, digest_size=16), 3)
    return Opening(
        bytes=data.nbytes,
        clips=len(bank.clips),
        unverified=float(np.median(unverified)),
        slowest_unverified=max(unverified),
        verified=float(np.median(verified)),
        reading=float(np.median(reading)),
        digesting=float(np.median(digesting)),
    )


def seconds_of(work: Callable[[], object], times: int) -> list[float]:
    """Returns the seconds of each of `times` runs of `work`."""
    seconds = []
    for _ in range(times):
        began = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - began)
    return seconds


def state_of(bank: Bank) -> State:
    """Returns the bytes of one character's state."""
    memory, poses = Memory.begin(1, RATE), Evaluator(bank).poses(1)
    return State(
        request=REQUEST.itemsize,
        memory=memory.state.nbytes,
        pose=poses.root_positions.nbytes + poses.rotations.nbytes,
    )


def held_by_processes(bank: Path) -> list[dict[str, int]]:
    """Returns the bytes of a bank's tables that each of PROCESSES processes holds, by field, while all have it open."""
    context = multiprocessing.get_context("spawn")
    pipes = [context.Pipe() for _ in range(PROCESSES)]
    processes = [context.Process(target=_hold, args=(bank, theirs)) for _, theirs in pipes]
    for process in processes:
        process.start()
    for (ours, theirs), _ in zip(pipes, processes, strict=True):
        theirs.close()
        ours.recv()  # raises EOFError if the process failed
    held = [table_pages(Path(f"/proc/{process.pid}/smaps").read_text(), str(bank)) for process in processes]
    for (ours, _), process in zip(pipes, processes, strict=True):
        ours.send("end")
        process.join()
    return held


def _hold(path: Path, pipe: Connection) -> None:
    """Opens a bank, evaluates splices that read every clip in many places, and waits for the parent process."""
    bank = Bank.open(path, verify=False)
    evaluator = Evaluator(bank)
    for requests in request_sets(bank, 20_000, Scene()):
        evaluator.evaluate(requests, evaluator.poses(len(requests)))
    pipe.send("ready")
    pipe.recv()


def table_pages(smaps: str, folder: str) -> dict[str, int]:
    """Returns bytes by FIELDS, summed over all mapped files below `folder`, from the text of /proc/PID/smaps."""
    total, ours = dict.fromkeys(FIELDS, 0), False
    for line in smaps.splitlines():
        if HEADING.match(line):
            ours = folder in line
        elif ours and (field := line.split(":")[0]) in total:
            total[field] += 1024 * int(line.split()[1])
    return total


def show(opening: Opening, state: State, held: Sequence[dict[str, int]]) -> None:
    """Prints all results."""
    console, gigabytes = Console(width=110), opening.bytes / 1e9
    table = Table(
        title=f"A bank of {gigabytes:.2f} GB in {opening.clips:,} clips, in the page cache", title_justify="left"
    )
    for column in ("", "ms", "GB/s"):
        table.add_column(column, justify="right" if column else "left")
    table.add_row("open without verification, median", f"{1e3 * opening.unverified:.1f}", "")
    table.add_row("open without verification, slowest", f"{1e3 * opening.slowest_unverified:.1f}", "")
    for label, seconds in (
        ("open with verification", opening.verified),
        ("digest of the same number of bytes", opening.digesting),
        ("sum of the same number of bytes", opening.reading),
    ):
        table.add_row(label, f"{1e3 * seconds:,.0f}", f"{gigabytes / seconds:.2f}")
    console.print(table)
    table = Table(title="Pages of the tables held by simultaneous processes, MB", title_justify="left")
    for column in ("process", *FIELDS):
        table.add_column(column, justify="right")
    for number, one in enumerate(held, 1):
        table.add_row(str(number), *(f"{one[field] / 1e6:.1f}" for field in FIELDS))
    console.print(table)
    console.print(f"Per character: request {state.request} B, memory {state.memory} B, pose {state.pose} B")


if __name__ == "__main__":
    run(lambda: typer.run(main))
