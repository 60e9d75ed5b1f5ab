"""Measures how much the choice of the baseline matters: `python -m bench.quality.baselines [CLIPS] [--pairs FILE]`.

Builds a bank with each clip that contains a stride as the baseline, and prints how close its splices are to the truth.
The automatic choice is marked.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.clips import bank_of
from bench.quality.measures import upper_body_errors
from bench.quality.pair_list import PAIRS, grid_pairs, read_pairs, truth_of
from bench.quality.scores import score_clip
from motionsplice.cli import run
from motionsplice.motion.errors import BaselineError
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: the built-in motions")] = None,
    pairs: Annotated[Path, typer.Option(help="CSV file of pairs, used with CLIPS")] = PAIRS,
) -> None:
    """Prints one row per baseline clip."""
    judged = [pair for pair in (read_pairs(pairs) if clips else grid_pairs()) if pair.truth]
    table = Table(title=f"{len(judged)} pairs: mean error / mean error of the naive splice")
    for column in ("baseline", "stride s", "mean", "median", "worst", "leg distance cm", "lowest concentration"):
        table.add_column(column, justify="right" if table.columns else "left")
    with tempfile.TemporaryDirectory() as folder:
        chosen = bank_of(clips, None, Path(folder) / "auto")
        for entry in chosen.clips:
            try:
                bank = bank_of(clips, entry.name, Path(folder) / entry.name)
            except BaselineError:
                continue
            evaluator, ratios = Evaluator(bank), []
            for pair in judged:
                truth = truth_of(pair, bank)
                assert truth is not None
                naive, splice = (
                    upper_body_errors(
                        evaluator.clip(Splice(pair.locomotion, pair.action, method=method)), truth, bank.roles
                    ).mean()
                    for method in ("naive", "splice")
                )
                ratios.append(splice / naive)
            walks = [score_clip(bank, clip.name) for clip in bank.clips if clip.kind == "locomotion"]
            lowest = min(walks, key=lambda one: one.concentration if one.concentration is not None else 1.0)
            table.add_row(
                f"{entry.name} (automatic)" if entry.name == chosen.baseline.clip else entry.name,
                f"{bank.baseline.end - bank.baseline.start:.2f}",
                *(f"{measure(ratios):.3f}" for measure in (np.mean, np.median, np.max)),
                f"{100.0 * np.mean([clip.mean_mismatch for clip in bank.clips]):.1f}",
                f"{lowest.concentration:.3f} ({lowest.clip})",
            )
    Console(width=120).print(table)


if __name__ == "__main__":
    run(lambda: typer.run(main))
