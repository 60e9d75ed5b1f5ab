"""Reads damaged files in processes with a memory limit, and counts what comes of it."""

from __future__ import annotations

import io
import re
import resource
import signal
import subprocess
import tempfile
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from pathlib import Path
from random import Random
from typing import Any

from bench.hostile.good_files import Good, hostile
from motionsplice.motion.errors import MotionError
from motionsplice.motion.formats.fbx import worker as fbx_worker
from motionsplice.motion.formats.files import clips_in, files_behind
from motionsplice.motion.formats.reading import read_clip

MOST_MEMORY = 256 * 2**20  # bytes that reading a file may add
MOST_SECONDS = 1.0  # of the processor, as other work on the machine slows the clock on the wall
HANGING = 20  # seconds on the wall, after which a process is ended
BATCHES = {"fbx": 20}  # files a process: ufbx keeps their memory
BATCH = 500  # of other kinds
MOST_CLIPS = 3  # read from one file
IN_MEMORY = Path("/dev/shm")  # of Linux: on a disk, writing a file takes longer than reading it
PAGE = resource.getpagesize()
FORK = get_context("fork")  # a process begins with all that is imported


@dataclass
class Tally:
    """The outcomes of reading files: how many of each, the slowest, and bad ones with the number of a file."""

    outcomes: Counter[str] = field(default_factory=Counter)
    bad: dict[str, int] = field(default_factory=dict)
    slowest: float = 0.0
    growth: int = 0

    def add(self, other: Tally) -> None:
        """Adds the other's files to these."""
        self.outcomes += other.outcomes
        self.bad = other.bad | self.bad
        self.slowest, self.growth = max(self.slowest, other.slowest), max(self.growth, other.growth)


@dataclass(frozen=True, eq=False)
class Batch:
    """A process that reads files `first` up to `stop`, and says in `at` which one it is at."""

    first: int
    stop: int
    process: Any
    at: Any


def damaged(kind: str, goods: list[Good], seed: int, number: int) -> Good:
    """Returns the damaged file of this number: the same one for the same seed."""
    return hostile(kind, goods, Random(f"{seed} {number}"))


def read_damaged(kind: str, goods: list[Good], seed: int, count: int, jobs: int) -> Tally:
    """Damages and reads `count` files, in `jobs` processes at a time."""
    if kind == "fbx":
        import_module("ufbx")  # once, rather than in each process
    tally, running = Tally(), dict[Connection, Batch]()
    size = BATCHES.get(kind, BATCH)
    waiting = [(first, min(first + size, count)) for first in range(0, count, size)][::-1]
    while waiting or running:
        while waiting and len(running) < jobs:
            first, stop = waiting.pop()
            ours, own = FORK.Pipe(duplex=False)
            at = FORK.Value("q", first, lock=False)
            process = FORK.Process(target=_read_batch, args=(own, kind, goods, seed, first, stop, at))
            process.start()
            own.close()
            running[ours] = Batch(first, stop, process, at)
        ended = wait(list(running))
        for result in [one for one in running if one in ended]:
            batch = running.pop(result)
            try:
                tally.add(result.recv())
                batch.process.join()
            except EOFError:
                batch.process.join()
                culprit = int(batch.at.value)
                how = f"the process ended with {batch.process.exitcode}"
                is_typed = kind == "fbx" and batch.process.exitcode != -signal.SIGALRM  # by the process that waits
                tally.add(Tally(Counter({how: 1}), {} if is_typed else {how: culprit}))
                rest = [(batch.first, culprit), (culprit + 1, batch.stop)]
                waiting += [(first, stop) for first, stop in rest if first < stop]
            result.close()
    return tally


def _read_batch(result: Connection, kind: str, goods: list[Good], seed: int, first: int, stop: int, at: Any) -> None:
    size = int(Path("/proc/self/statm").read_text().split()[0]) * PAGE
    resource.setrlimit(resource.RLIMIT_AS, (size + MOST_MEMORY, size + MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("error")
    if kind == "fbx":
        _read_fbx_here()
    begun = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    tally = Tally()
    with tempfile.TemporaryDirectory(dir=IN_MEMORY if IN_MEMORY.is_dir() else None) as name:
        for number in range(first, stop):
            at.value = number
            good = damaged(kind, goods, seed, number)
            for file, data in good.files.items():
                (Path(name) / file).write_bytes(data)
            signal.alarm(HANGING)
            began = time.process_time()
            outcome, is_bad = read(Path(name) / good.name)
            taken = time.process_time() - began
            signal.alarm(0)
            if taken > MOST_SECONDS:
                outcome, is_bad = f"slow: {outcome}", True
            tally.outcomes[outcome] += 1
            if is_bad:
                tally.bad.setdefault(outcome, number)
            tally.slowest = max(tally.slowest, taken)
    tally.growth = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - begun) * 1024
    result.send(tally)


def _read_fbx_here() -> None:
    """Has FBX files read by this process, which is a child as that of the reader is, and under a limit of its own."""

    def run(command: list[str], input: bytes, **_: Any) -> subprocess.CompletedProcess[bytes]:  # noqa: A002
        output = io.BytesIO()
        fbx_worker.main(io.BytesIO(input), output)
        return subprocess.CompletedProcess(command, 0, output.getvalue(), b"")

    subprocess.run = run  # type: ignore[assignment]
    fbx_worker.limit_memory = lambda size: None


def read(path: Path) -> tuple[str, bool]:
    """Reads the clips of a file. Returns what came of it in words without numbers, and whether it is a bug."""
    try:
        files_behind(path)
        for animation in list(clips_in(path).values())[:MOST_CLIPS]:
            clip = read_clip(path, animation=animation).clip
            f"{clip.name} {clip.skeleton.names}".encode()
    except MotionError as error:
        str(error).encode()  # as printing does
        problem = re.sub(r"'[^']*'|\"[^\"]*\"|-?\d[\w.+-]*", "…", error.problem)
        return f"{type(error).__name__}: {problem[:70]}", False
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__} in {Path(frame.filename).name}, line {frame.lineno}: {str(error)[:50]}", True
    return "read", False
