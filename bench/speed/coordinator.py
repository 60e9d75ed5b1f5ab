"""Measures the coordinator of the offline job: `python -m bench.speed.coordinator [COUNT ...]`.

What one process does for all clips, whoever reads and aligns them: listing and digesting files, choosing the baseline,
giving neutrals, and writing the bank. The clips are names (hard links) of a few generated files of 1.5 s, one in ten a
locomotion, so that the cache has their results beforehand and no worker has anything to do. Each run is a process of
its own, whose peak memory is measured from before the job.
"""

from __future__ import annotations

import os
import resource
import shutil
import tempfile
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.speed.precompute import in_process
from motionsplice.cli import run
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank

COUNTS = (1_000, 10_000, 100_000)
GAITS = ("walk", "run", "curve", "side_step")
ACTIONS = ("carry_cup", "carry_box")
BASELINE = "walk_000000"
SECONDS, RATE = 1.5, 30.0
LOCOMOTIONS = 10  # one clip in so many


def main(
    counts: Annotated[list[int] | None, typer.Argument(help="Numbers of clips")] = None,
    folder: Annotated[Path | None, typer.Option(help="Where to put clips and banks, 40 kB a clip")] = None,
) -> None:
    """Prints time and memory, and how both grow with the number of clips."""
    rows = []
    columns = ("clips", "processor s", "ms per clip", "peak MB", "kB per clip")
    table = Table(*columns, title="The coordinator alone", box=None)
    for count in counts or COUNTS:
        with tempfile.TemporaryDirectory(dir=folder) as name:
            seconds, memory = in_process(time_coordinator, Path(name), count)
        rows.append((count, seconds, memory))
        each = f"{1e3 * seconds / count:.2f}", f"{memory / 1e6:.0f}", f"{memory / 1e3 / count:.1f}"
        table.add_row(f"{count:,}", f"{seconds:.1f}", *each)
    console = Console(width=100)
    console.print(table)
    if len(rows) > 1:
        numbers, seconds, memory = np.log(np.array(rows, np.float64).T)
        for what, values in (("time", seconds), ("memory", memory)):
            console.print(f"{what} grows with the number of clips to the power {np.polyfit(numbers, values, 1)[0]:.2f}")


def time_coordinator(folder: Path, count: int) -> tuple[float, float]:
    """Returns the processor's seconds of a job whose clips are all cached, and by how many bytes its process grew."""
    few = _write_clips(folder / "few", LOCOMOTIONS * len(GAITS))
    for baseline in (None, BASELINE):  # all strides, and then what is aligned to the one that is chosen of many
        build_bank(few, folder / "bank", baseline=baseline)
    clips = _write_clips(folder / "clips", count)
    before = _peak()
    began = time.process_time()
    outcome = build_bank(clips, folder / "bank")
    seconds = time.process_time() - began
    assert len(outcome.clips) == count == outcome.reused, "the cache did not have all results"
    shutil.rmtree(folder / "bank")
    return seconds, _peak() - before


def _write_clips(folder: Path, count: int) -> list[Path]:
    """Writes clips in two folders, for locomotions and for actions. Returns the folders."""
    for kind, names in (("locomotions", GAITS), ("actions", ACTIONS)):
        (folder / kind).mkdir(parents=True)
        for name in names:
            gait, action = (name, None) if kind == "locomotions" else ("walk", name)
            clip = make(gait, action, seconds=SECONDS, rate=RATE)
            (folder / f"{kind}-{name}").write_bytes(dump_bvh(clip))
    settings = []
    for number in range(count):
        kind, names = ("locomotions", GAITS) if number % LOCOMOTIONS == 0 else ("actions", ACTIONS)
        name = names[number // LOCOMOTIONS % len(names)]
        os.link(folder / f"{kind}-{name}", folder / kind / f"{name}_{number:06}.bvh")
        settings += [f'[{name}_{number:06}]\nkind = "action"\n'] if kind == "actions" else []
    (folder / "actions" / "clips.toml").write_text("".join(settings))
    return [folder / "locomotions", folder / "actions"]


def _peak() -> float:
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


if __name__ == "__main__":
    run(lambda: typer.run(main))
