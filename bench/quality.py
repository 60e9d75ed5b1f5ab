"""Splices against ground truth: `python -m bench.quality CLIPS [--pairs FILE]`, or the built-in grid without CLIPS.

Prints, per pair, the mean error of the upper body's joints for the naive splice in centimetres, and that of the
papers' whole-clip splice (exact) and of the bank's (splice) as ratios to it, for each posture form; how far the posture
of `absolute` is from the action's; how far the arms are out of step with the legs, in degrees of a stride, where they
swing; and the neck's jitter as a ratio to the rougher of the two sources'.
"""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, get_args

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.clips import bank_of
from bench.measures import lag_error, neck_jitter, posture_error, upper_body_errors
from motion.clip import Clip
from motion.procedural.library import ACTIONS, LOCOMOTIONS, truth
from motion.roles import find_roles
from precompute.common_skeleton import onto_skeleton
from precompute.splice import Posture, splice_exact, splice_naive
from runtime.bank import Bank
from runtime.evaluator import Evaluator

POSTURES: tuple[Posture, ...] = get_args(Posture)
PAIRS = Path(__file__).parent / "pairs.csv"


@dataclass(frozen=True)
class Score:
    """One pair: naive error in metres, the others as ratios to it, by posture form; posture errors and lags in radians.

    lag and jitter are of the naive splice and of the bank's.
    """

    pair: str
    naive: float
    exact: dict[Posture, float]
    splice: dict[Posture, float]
    exact_posture: float
    splice_posture: float
    lag: tuple[float, float]
    jitter: tuple[float, float]


def score(evaluator: Evaluator, locomotion: str, action: str, truth: Clip) -> Score:
    """Scores one pair over the frames that the pairwise alignment covers."""
    bank = evaluator.bank
    clip_l, clip_u = bank.motion(locomotion), bank.motion(action)
    neutrals = bank.motion(bank.neutral(locomotion)), bank.motion(bank.neutral(action))
    exact = {
        posture: splice_exact(clip_l, clip_u, bank.roles, posture=posture, neutrals=neutrals).clip
        for posture in POSTURES
    }
    covered = exact["off"].frame_count
    splice = {posture: evaluator.clip(locomotion, action, posture=posture) for posture in POSTURES}

    def error(result: Clip) -> float:
        return float(upper_body_errors(result.frames(0, covered), truth, bank.roles).mean())

    naive_clip = splice_naive(clip_l, clip_u, bank.roles)
    naive = error(naive_clip)
    entry = bank.clip(locomotion)
    phase = np.asarray(bank.tables["phase_of_frame"][entry.first_row : entry.first_row + covered])
    rougher = max(neck_jitter(clip, bank.roles) for clip in (clip_l, clip_u))
    judged = [clip.frames(0, covered) for clip in (naive_clip, splice["relative"])]
    lags = [lag_error(clip, truth, phase, bank.roles) for clip in judged]
    jitters = [neck_jitter(clip, bank.roles) / rougher for clip in judged]
    return Score(
        pair=f"{locomotion} <- {action}",
        naive=naive,
        exact={posture: error(clip) / naive for posture, clip in exact.items()},
        splice={posture: error(clip) / naive for posture, clip in splice.items()},
        exact_posture=posture_error(exact["absolute"], clip_u, bank.roles),
        splice_posture=posture_error(splice["absolute"], clip_u, bank.roles),
        lag=(lags[0], lags[1]),
        jitter=(jitters[0], jitters[1]),
    )


def show(scores: Iterable[Score], title: str) -> None:
    """Prints a table of scores, and their means."""
    table = Table(title=title)
    table.add_column("locomotion <- action", no_wrap=True)
    columns = ["naive cm", *(f"exact\n{p}" for p in POSTURES), *(f"splice\n{p}" for p in POSTURES)]
    columns += [
        "exact\nposture °",
        "splice\nposture °",
        "naive\nlag °",
        "splice\nlag °",
        "naive\njitter",
        "splice\njitter",
    ]
    for column in columns:
        table.add_column(column, justify="right")
    rows = []
    for one in scores:
        ratios = [*(one.exact[p] for p in POSTURES), *(one.splice[p] for p in POSTURES)]
        angles = np.degrees([one.exact_posture, one.splice_posture, *one.lag]).tolist()
        rows.append([100 * one.naive, *ratios, *angles, *one.jitter])
        table.add_row(one.pair, *map(_told, rows[-1]))
    table.add_section()
    table.add_row("mean", *map(_told, np.nanmean(rows, axis=0).tolist()))
    Console(width=190).print(table)


def _told(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.2f}"


def scores_of_pairs(bank: Bank, pairs: Path) -> Iterator[Score]:
    """Scores of a CSV's pairs (locomotion, action); the truth is the locomotion's own upper body."""
    evaluator = Evaluator(bank)
    with pairs.open(newline="") as file:
        for row in csv.DictReader(file):
            yield score(evaluator, row["locomotion"], row["action"], bank.motion(row["locomotion"]))


def scores_of_grid(bank: Bank) -> Iterator[Score]:
    """Scores of every built-in action on every built-in locomotion, against the generated truth."""
    evaluator = Evaluator(bank)
    for locomotion in LOCOMOTIONS:
        for action in ACTIONS:
            real = truth(locomotion, action)
            real = onto_skeleton(real, find_roles(real.skeleton), bank.skeleton, bank.roles)
            yield score(evaluator, locomotion, action, real)


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; the built-in grid if not given")] = None,
    pairs: Annotated[Path, typer.Option(help="CSV with columns locomotion, action")] = PAIRS,
    baseline: Annotated[str | None, typer.Option(help="Baseline clip")] = None,
) -> None:
    """Prints how near splices come to the truth."""
    with tempfile.TemporaryDirectory() as folder:
        bank = bank_of(clips, baseline, Path(folder))
        if clips is None:
            show(scores_of_grid(bank), "Built-in actions on built-in locomotions")
        else:
            show(scores_of_pairs(bank, pairs), f"Pairs of {pairs.name}")


if __name__ == "__main__":
    typer.run(main)
