"""Seconds that the offline job takes: `python -m bench.precompute CLIPS [--jobs N] [--rounds 3]`, warm kernels."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from motionsplice.cli import run
from precompute.job import precompute
from runtime.bank import Bank


def main(
    clips: Annotated[Path, typer.Argument(help="Folder of clips")],
    baseline: Annotated[str | None, typer.Option(help="Baseline clip")] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Processes")] = 1,
    rounds: Annotated[int, typer.Option(min=1)] = 3,
) -> None:
    """Prints the job's time over a folder, from files to bank, beside the time of the motion itself."""
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        precompute([clips], Path(folder), baseline=baseline, jobs=jobs)  # compiles the kernels if need be
        for _ in range(rounds):
            began = time.perf_counter()
            outcome = precompute([clips], Path(folder), baseline=baseline, jobs=jobs)
            seconds.append(time.perf_counter() - began)
        motion = sum(clip.duration for clip in Bank.open(folder).clips)
    median = float(np.median(seconds))
    print(f"{len(outcome.clips)} clips, {motion:.1f} s of motion, baseline {outcome.baseline.name!r}")
    print(f"median {median:.2f} s, slowest {max(seconds):.2f} s of {rounds}: {motion / median:.0f} times real time")
    for name, error in outcome.failed.items():
        print(f"{name} failed: {error}")


if __name__ == "__main__":
    run(lambda: typer.run(main))
