"""Measures mirror images: `python -m bench.quality.mirroring [CLIPS] [--baseline NAME]`.

joints       How far is a joint of the mirror image from the mirror image of its twin? It is 0 on a symmetric rig.
phase        How far is the phase that the mirror image gets, half a cycle later, from that of a new alignment?
splice       The clip's mirror image gives the upper body, the clip the legs, and the clip itself is the truth: only a
             walk straight ahead is its own twin. Mean distance of the upper body, hips at one place; naive beside it.
time         What does a mirrored splice cost, relative to the splice? 1,000 characters, paired.
"""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.clips import bank_of
from bench.quality.measures import upper_body_errors
from bench.rounds import interleaved, paired_ratio
from motionsplice.cli import run
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.twins import MIRROR
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.mirrored import MIRRORED
from motionsplice.runtime.requests import Method, Poses, Requests
from motionsplice.runtime.splice import Splice

COUNT, ROUNDS = 1000, 200
SIDES = {"locomotion": (1, 0), "action": (0, 1), "both": (1, 1)}


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: the built-in motions")] = None,
    baseline: Annotated[str | None, typer.Option(help="Baseline clip; default: chosen automatically")] = None,
) -> None:
    """Prints how exact mirror images are, and what they cost."""
    with tempfile.TemporaryDirectory() as folder:
        bank = bank_of(clips, baseline, Path(folder))
        console = Console(width=110)
        console.print(exactness(bank))
        console.print(times(bank))


def exactness(bank: Bank) -> Table:
    """Measures the mirror image of each clip with a gait."""
    table = Table("clip", title="Mirror images", title_justify="left")
    for column in ("joints, worst mm", "phase, median", "phase, worst", "splice cm", "naive cm"):
        table.add_column(column, justify="right")
    evaluator, ring = Evaluator(bank), find_baseline(bank.motion(bank.baseline.clip), bank.roles)
    for clip in bank.clips:
        if not clip.gait or bank.mirror is None:
            continue
        own, image = bank.motion(clip.name), bank.motion(clip.name + MIRRORED)
        paired = bank.mirror.twins >= 0
        away = joint_positions(image) - joint_positions(own)[:, bank.mirror.twins] * MIRROR
        apart = align(image, bank.roles, ring).phase - align(own, bank.roles, ring).phase - 0.5
        apart = np.abs(apart - np.round(np.median(apart)))
        errors = [100.0 * _twin_error(evaluator, clip.name, method) for method in ("splice", "naive")]
        table.add_row(
            clip.name,
            f"{1e3 * np.linalg.norm(away[:, paired], axis=-1).max():.1f}",
            *(f"{value:.3f}" for value in (np.median(apart), apart.max())),
            *(f"{error:.2f}" for error in errors),
        )
    return table


def _twin_error(evaluator: Evaluator, name: str, method: Method) -> float:
    """Returns the mean error in metres of a clip with the upper body of its mirror image."""
    bank = evaluator.bank
    made = evaluator.clip(Splice(name, name + MIRRORED, method=method))
    return float(upper_body_errors(made, bank.motion(name), bank.roles).mean())


def times(bank: Bank) -> Table:
    """Measures the time of a splice of mirror images."""
    evaluator, draw = Evaluator(bank), np.random.default_rng(0)
    poses, plain, count = evaluator.poses(COUNT), Requests.empty(COUNT), len(bank.clips)
    plain.locomotion[:], plain.action[:] = draw.integers(0, count, (2, COUNT))
    plain.time[:] = draw.random(COUNT) * [bank.clips[one].duration for one in plain.locomotion]
    work = {"neither": plain}
    for name, (below, above) in SIDES.items():
        work[name] = Requests(plain.records.copy())
        work[name].locomotion[:] += below * count
        work[name].action[:] += above * count
    seconds = interleaved({name: partial(_evaluate, evaluator, one, poses) for name, one in work.items()}, ROUNDS)
    table = Table("mirrored", title="Time of a splice", title_justify="left")
    for column in ("ns", "/ neither"):
        table.add_column(column, justify="right")
    for name, taken in seconds.items():
        ratio = paired_ratio(taken, seconds["neither"])
        table.add_row(name, f"{1e9 * np.median(taken) / COUNT:.0f}", f"{ratio:.2f}")
    return table


def _evaluate(evaluator: Evaluator, requests: Requests, poses: Poses, _: int) -> None:
    evaluator.evaluate(requests, poses)


if __name__ == "__main__":
    run(lambda: typer.run(main))
