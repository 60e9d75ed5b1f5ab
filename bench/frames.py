"""Time per character-frame: `python -m bench.frames [--bank BANK] [--characters 1000]`, kernels warm.

Rounds of all methods are interleaved, and their medians and 99th percentiles are printed per character-frame, with
the naive splice as the baseline. Characters play random pairs of clips at random times.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.clips import bank_of
from motionsplice.cli import run
from runtime.bank import Bank
from runtime.evaluator import Evaluator
from runtime.requests import METHODS, POSTURES, Memory, Requests


def random_requests(bank: Bank, count: int, method: str, posture: str, seed: int = 0) -> Requests:
    """Characters that play any pair of clips at any time."""
    draw = np.random.default_rng(seed)
    durations = np.array([clip.duration for clip in bank.clips])
    requests = Requests.empty(count)
    requests.locomotion[:] = draw.integers(0, len(bank.clips), count)
    requests.action[:] = draw.integers(0, len(bank.clips), count)
    requests.time[:] = draw.random(count) * durations[requests.locomotion]
    requests.method[:], requests.posture[:] = METHODS[method], POSTURES[posture]
    return requests


def main(
    bank: Annotated[Path | None, typer.Option(help="A bank; one of the built-in motions if not given")] = None,
    characters: Annotated[int, typer.Option(min=1)] = 1000,
    rounds: Annotated[int, typer.Option(min=3)] = 200,
) -> None:
    """Prints microseconds per character-frame of each method."""
    with tempfile.TemporaryDirectory() as folder:
        opened = Bank.open(bank) if bank else bank_of(None, "walk", Path(folder))
        evaluator = Evaluator(opened)
        poses = evaluator.poses(characters)
        memory = Memory.begin(characters, rate=60.0)
        positions = np.empty((characters, opened.skeleton.joint_count, 3), np.float32)
        forms = [("naive", "off"), ("none", "off"), *(("splice", posture) for posture in POSTURES)]
        work: dict[str, Callable[[], None]] = {}
        for method, posture in forms:
            requests = random_requests(opened, characters, method, posture)
            label = f"{method}, posture {posture}" if method == "splice" else method
            work[label] = lambda requests=requests: evaluator.evaluate(requests, poses, memory)  # type: ignore[misc]
        work["world positions"] = lambda: evaluator.world_positions(poses, positions)
        seconds: dict[str, list[float]] = {label: [] for label in work}
        for run in work.values():
            run()
        for _ in range(rounds):
            for label, run in work.items():
                began = time.perf_counter()
                run()
                seconds[label].append((time.perf_counter() - began) / characters)
    clip = opened.clips[0].name
    seconds["one character, by name"] = []
    for _ in range(rounds):
        began = time.perf_counter()
        evaluator.pose(clip, 0.0, clip)
        seconds["one character, by name"].append(time.perf_counter() - began)
    table = Table(title=f"{characters} characters, {opened.skeleton.joint_count} joints, {rounds} warm rounds")
    for column in ("", "median us", "p99 us", "ratio to naive"):
        table.add_column(column, justify="right")
    naive = np.median(seconds["naive"])
    for label, samples in seconds.items():
        median, late = np.percentile(samples, [50, 99])
        table.add_row(label, f"{1e6 * median:.3f}", f"{1e6 * late:.3f}", f"{median / naive:.2f}")
    Console().print(table)


if __name__ == "__main__":
    run(lambda: typer.run(main))
