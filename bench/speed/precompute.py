"""Measures the offline job: `python -m bench.speed.precompute [CLIPS] [--jobs N] [--rounds 3] [--out FILE.json]`.

Without CLIPS, processes generated clips of 31 joints at 120 frames per second: single clips of 10 s, 1 min and 10 min,
and then 10, 100 and 1,000 clips of 4 s. With CLIPS, processes a folder of files. Each run is a separate process, whose
memory is measured and whose kernels are warm before its clocks start. Processor time is that of the job and its worker
processes, user and system; it says more than the wall clock where others use the machine too. Times include writing to
disk. Files that were just written are read from the page cache.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.speed.generated_clips import generated, write_generated
from motionsplice.cli import run
from motionsplice.motion.errors import MotionError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.retarget.rig import Rig
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.job.bank_builder import write_bank
from motionsplice.precompute.job.destination import CACHE
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.processes import ONE_THREAD, end_with_parent
from motionsplice.precompute.preparation.prepared import prepare
from motionsplice.runtime.format.manifest import Manifest

LENGTHS = (10.0, 60.0, 600.0)  # seconds
COUNTS = (10, 100, 1000)
SHORT = 4.0  # seconds
MEGABYTE = 1e6


@dataclass(frozen=True)
class Timing:
    """One run: seconds of motion, seconds of processors and of the wall clock, and peak memory in bytes.

    memory: of the job's process. worker_memory: of its largest worker.
    """

    what: str
    motion: float
    processor: float
    wall: float
    memory: float = 0.0
    worker_memory: float = 0.0


class Clock:
    """Seconds since it was made: of this process and its children that have ended, and by the wall clock."""

    def __init__(self) -> None:
        self._began = self._now()

    def seconds(self) -> tuple[float, float]:
        """Returns the seconds of processors, user and system, and of the wall clock."""
        processor, wall = (now - began for now, began in zip(self._now(), self._began, strict=True))
        return processor, wall

    @staticmethod
    def _now() -> tuple[float, float]:
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(one.ru_utime + one.ru_stime for one in used), time.perf_counter()


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: generated clips")] = None,
    baseline: Annotated[str | None, typer.Option(help="Baseline clip; default: chosen automatically")] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Number of processes of the parallel runs")] = 2,
    rounds: Annotated[int, typer.Option(min=2, help="Rounds")] = 3,
    out: Annotated[Path | None, typer.Option(help="JSON file for all timings")] = None,
) -> None:
    """Prints times and memory, and how the time grows with the length and the number of clips."""
    console, timings = Console(width=120), []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if clips is not None:
            timings = _folder_runs(clips, baseline, folder / "bank", jobs, rounds)
        else:
            lengths = [timing for _ in range(rounds) for timing in in_process(time_lengths)]
            console.print(_table(lengths, "One clip on one core"))
            for what in dict.fromkeys(timing.what.split(",")[0] for timing in lengths):
                console.print(_growth(what, [one for one in lengths if one.what.startswith(what)]))
            counts = []
            for count in COUNTS:
                in_process(write_generated, folder / str(count), count, SHORT)
                counts += _folder_runs(folder / str(count), None, folder / "bank", jobs, rounds, f"{count} clips, ")
                shutil.rmtree(folder / str(count))
            console.print(_table(counts, f"Clips of {SHORT:g} s, from files to a bank"))
            cold = [one for one in counts if one.what.endswith("cold, 1 process")]
            console.print(_growth("cold, 1 process", cold))
            timings = lengths + counts
        if clips is not None:
            console.print(_table(timings, str(clips)))
    if out is not None:
        out.write_text(json.dumps([asdict(timing) for timing in timings], indent=1))


def in_process(function: Callable[..., Any], *arguments: Any) -> Any:
    """Calls a function in a new process, so that its memory is measured separately, and returns its result.

    BLAS has one thread there, as in `motionsplice precompute`.
    """
    os.environ.update(ONE_THREAD)
    with ProcessPoolExecutor(1, get_context("spawn"), end_with_parent) as pool:
        return pool.submit(function, *arguments).result()


def time_lengths() -> list[Timing]:
    """Times clips of each length: reading BVH text, aligning as an action, and writing a bank with their neutral."""
    base = generated("walk", LENGTHS[0], seed=1)
    with tempfile.TemporaryDirectory() as name:
        file, bank = Path(name) / "action.bvh", Path(name) / "bank"
        file.write_bytes(dump_bvh(base))
        reading = read_clip(file, unit="m")
        rig, ring = Rig(reading.clip.skeleton, reading.roles), find_baseline(reading.clip, reading.roles)
        neutral = prepare(replace(reading.clip, name="neutral"), rig.roles, rig, ring)
        neutral = replace(neutral, neutral="neutral")
        timings = []
        for seconds in (LENGTHS[0], *LENGTHS):
            file.write_bytes(dump_bvh(generated("walk", seconds, seed=2)))
            clock = Clock()
            reading = read_clip(file, unit="m")
            read = clock.seconds()
            made = prepare(reading.clip, rig.roles, rig, ring)
            aligned = clock.seconds()
            write_bank(
                bank, rig, ring, {"neutral": neutral, made.name: replace(made, kind="action", neutral="neutral")}
            )
            written = clock.seconds()
            shutil.rmtree(bank)
            for what, begin, end in (
                ("clip to aligned", read, aligned),
                ("clip to tables", read, written),
                ("BVH file to tables", (0.0, 0.0), written),
            ):
                processor, wall = (after - before for before, after in zip(begin, end, strict=True))
                timings.append(Timing(f"{what}, {seconds:g} s", seconds, processor, wall, _peak(resource.RUSAGE_SELF)))
    return timings[3:]  # the first length only warmed up the kernels


def time_job(clips: Path, bank: Path, baseline: str | None, jobs: int) -> tuple[float, float, float, float]:
    """Returns the seconds of the job, by processors and wall clock, and the peak memory of its process and workers."""
    with tempfile.TemporaryDirectory() as name:
        write_generated(Path(name) / "clips", 1, SHORT)
        build_bank([Path(name) / "clips"], Path(name) / "bank")  # warms up the kernels
    clock = Clock()
    try:
        build_bank([clips], bank, baseline=baseline, jobs=jobs)
    except MotionError as error:
        sys.exit(str(error))
    return *clock.seconds(), _peak(resource.RUSAGE_SELF), _peak(resource.RUSAGE_CHILDREN)


def _folder_runs(
    clips: Path, baseline: str | None, bank: Path, jobs: int, rounds: int, label: str = ""
) -> list[Timing]:
    """Times cold runs with one process and with several, then a run without changes, then one with a changed clip.

    This process maps no bank: the peak memory of a process that it starts would count its own.
    """
    timings = []
    copies = bank.with_name("copies")
    shutil.copytree(clips, copies)
    for _ in range(rounds):
        taken = {}
        for processes in dict.fromkeys((jobs, 1)):
            shutil.rmtree(bank, ignore_errors=True)
            many = f"{processes} process{'es' * (processes > 1)}"
            taken[f"cold, {many}"] = in_process(time_job, copies, bank, baseline, processes)
        taken["nothing changed"] = in_process(time_job, copies, bank, baseline, 1)
        changed = Manifest.read(bank).clips[-1].name
        file = next(file for file in sorted(copies.iterdir()) if file.stem == changed and file.suffix != ".asf")
        file.write_bytes(file.read_bytes() + b"\n")
        taken["one clip changed"] = in_process(time_job, copies, bank, baseline, 1)
        motion = sum(clip.duration for clip in Manifest.read(bank).clips)
        timings += [Timing(label + what, motion, *measured) for what, measured in taken.items()]
    shutil.rmtree(bank / CACHE)
    shutil.rmtree(copies)
    return timings


def _peak(who: int) -> float:
    return 1024.0 * resource.getrusage(who).ru_maxrss


def _table(timings: list[Timing], title: str) -> Table:
    columns = ("", "motion s", "processor s", "slowest s", "times real time", "wall s", "times", "peak MB", "worker MB")
    table = Table(title=f"{title}: medians")
    for column in columns:
        table.add_column(column, justify="right" if table.columns else "left")
    for what in dict.fromkeys(timing.what for timing in timings):
        rounds = [one for one in timings if one.what == what]
        motion, processor, wall = (median(getattr(one, of) for one in rounds) for of in ("motion", "processor", "wall"))
        table.add_row(
            what,
            f"{motion:.0f}",
            f"{processor:.3f}",
            f"{max(one.processor for one in rounds):.3f}",
            f"{motion / processor:.0f}",
            f"{wall:.3f}",
            f"{motion / wall:.0f}",
            f"{max(one.memory for one in rounds) / MEGABYTE:.0f}",
            f"{max(one.worker_memory for one in rounds) / MEGABYTE:.0f}",
        )
    return table


def _growth(what: str, timings: list[Timing]) -> str:
    """Describes how processor time grows with the motion's length: the fitted exponent (1: linear) and its error."""
    x, y = (np.log([getattr(one, field) for one in timings]) for field in ("motion", "processor"))
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    power = f"{slope:.2f} ± {np.sqrt(covariance[0, 0]):.2f}"
    return f"{what}: processor time grows with the motion's length to the power {power}"


if __name__ == "__main__":
    run(lambda: typer.run(main))
