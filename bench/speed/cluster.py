"""Compares a Dask cluster on this machine with processes: `python -m bench.speed.cluster [COUNT] [--workers 2]`.

Generated clips of 31 joints at 120 frames per second, 4 s each, from files to a bank, in turns. The cluster is started
before its clock, and its workers have loaded their kernels; so have processes, as far as they are started by then.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Annotated

import typer
from distributed import LocalCluster
from rich.console import Console
from rich.table import Table

from bench.speed.generated_clips import write_generated
from bench.speed.precompute import SHORT, in_process
from motionsplice.cli import run
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.scheduler import executor_of


def main(
    count: Annotated[int, typer.Argument(help="Number of clips")] = 1000,
    workers: Annotated[int, typer.Option(min=2, help="Processes, and workers of the cluster")] = 2,
    rounds: Annotated[int, typer.Option(min=1, help="Rounds")] = 3,
) -> None:
    """Prints the seconds of both, and their ratio."""
    table = Table("round", "processes, s", "Dask, s", "ratio", title=f"{count:,} clips, {workers} workers", box=None)
    ratios = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        in_process(write_generated, folder / "few", 2 * workers, SHORT)
        in_process(write_generated, folder / "clips", count, SHORT)
        options = {"n_workers": workers, "threads_per_worker": 1, "processes": True, "dashboard_address": "127.0.0.1:0"}
        with LocalCluster(host="127.0.0.1", **options) as cluster:
            for number in range(rounds):
                local, expected = in_process(time_build, folder, workers, None)
                spread, digest = in_process(time_build, folder, workers, cluster.scheduler_address)
                assert digest == expected, "the banks differ"
                ratios.append(spread / local)
                table.add_row(str(number + 1), f"{local:.1f}", f"{spread:.1f}", f"{ratios[-1]:.2f}")
    console = Console(width=100)
    console.print(table)
    console.print(f"median ratio {median(ratios):.2f}; the banks are equal")


def time_build(folder: Path, jobs: int, scheduler: str | None) -> tuple[float, str]:
    """Returns the seconds of a job without a cache, after one of few clips, and the digest of its bank."""
    if scheduler is None:
        build_bank([folder / "few"], folder / "bank", jobs=jobs)
        shutil.rmtree(folder / "bank")
        began = time.perf_counter()
        digest = build_bank([folder / "clips"], folder / "bank", jobs=jobs).digest
    else:
        with executor_of(scheduler) as executor:
            build_bank([folder / "few"], folder / "bank", executor=executor)
            shutil.rmtree(folder / "bank")
            began = time.perf_counter()
            digest = build_bank([folder / "clips"], folder / "bank", executor=executor).digest
    seconds = time.perf_counter() - began
    shutil.rmtree(folder / "bank")
    return seconds, digest


if __name__ == "__main__":
    run(lambda: typer.run(main))
