"""Compares splices with the truth at several starts of the action: `python -m bench.quality.starts [CLIPS]`.

Plain replacement may happen to be in step, or far out of it, so a ratio from one start is partly luck. Each error is
the mean over STARTS. Prints the mean and the worst ratio to plain replacement by group, of the built-in motions or of
the pairs of `bench/quality/pairs.csv` that have a truth.
"""

from __future__ import annotations

import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.clips import bank_of
from bench.quality.measures import upper_body_errors
from bench.quality.pair_list import PAIRS, Pair, grid_pairs, read_pairs, truth_of
from motionsplice.cli import run
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Method, Posture
from motionsplice.runtime.splice import Splice

STARTS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25)  # seconds of the action; those beyond a short clip's end are left out


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: the built-in motions")] = None,
    baseline: Annotated[str | None, typer.Option(help="Baseline clip; default: chosen automatically")] = None,
    posture: Annotated[Posture, typer.Option(help="How the splices keep the action's posture")] = "relative",
) -> None:
    """Prints one row for each group of pairs."""
    with tempfile.TemporaryDirectory() as folder:
        evaluator = Evaluator(bank_of(clips, baseline, Path(folder)))
        groups: defaultdict[str, list[tuple[float, str]]] = defaultdict(list)
        for pair in grid_pairs() if clips is None else read_pairs(PAIRS):
            if pair.truth:
                groups[pair.group or "built-in"].append(
                    (ratio(evaluator, pair, posture), f"{pair.locomotion} <- {pair.action}")
                )
    table = Table(
        title=f"Error / plain replacement's, posture {posture}, means of {len(STARTS)} starts", title_justify="left"
    )
    for column in ("group", "pairs", "mean", "worst", "above 1"):
        table.add_column(column, justify="right" if table.columns else "left")
    groups["all"] = [one for some in groups.values() for one in some]
    for name, found in groups.items():
        ratios, (most, where) = [one for one, _ in found], max(found)
        above = sum(one > 1.0 for one in ratios)
        table.add_row(name, str(len(found)), f"{np.mean(ratios):.3f}", f"{most:.2f} ({where})", str(above))
    Console(width=110).print(table)


def ratio(evaluator: Evaluator, pair: Pair, posture: Posture = "relative") -> float:
    """Returns the mean error of a pair's splices, divided by that of plain replacement."""
    truth, seconds = truth_of(pair, evaluator.bank), evaluator.bank.clip(pair.action).duration
    assert truth is not None

    def error(method: Method) -> float:
        made = [
            evaluator.clip(Splice(pair.locomotion, pair.action, start=start, method=method, posture=posture))
            for start in STARTS
            if start < seconds
        ]
        return float(np.mean([upper_body_errors(clip, truth, evaluator.bank.roles).mean() for clip in made]))

    return error("splice") / error("naive")


if __name__ == "__main__":
    run(lambda: typer.run(main))
