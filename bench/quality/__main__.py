"""Measures how close splices are to the true motion: `python -m bench.quality [CLIPS | --bank BANK] [--out FOLDER]`.

With CLIPS, judges the pairs of a CSV file. Without, judges the built-in motions: all actions on all locomotions, and
the examples of Heck's thesis (4.4). With --bank, judges a bank as it is: the pairs of a CSV file; without it, as the
built-in motions if the bank has them, or else all actions on all locomotions, whose truth is unknown. Prints tables.
With --out, also writes scores.json, which `motionsplice serve BANK --report` shows, and the report index.html.
`bench/quality/scores.py` explains each number.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.clips import bank_of
from bench.quality.document import document
from bench.quality.judge import STRIP_RATE, Judged, claim_values, errors_over_time, judge
from bench.quality.pair_list import EXAMPLES, PAIRS, grid_pairs, has_built_in_clips, pairs_of_bank, read_pairs
from bench.quality.report import Cell, by_part, claim_row, clip_table, means_table, pair_table, picture, write_report
from bench.quality.scores import Form, score_clip
from bench.quality.targets import BUILT_IN, OURS, REAL, targets
from motionsplice.cli import run
from motionsplice.commands.motion import Posture
from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator

FORMS = (Form("naive"), Form("additive"), Form("exact"), Form("splice"))
WORST_DRAWN = 4  # number of the grid's worst pairs that the report draws
OPEN = 2  # number of pictures that are open when the report loads

console = Console(width=250)


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: the built-in motions")] = None,
    bank_folder: Annotated[
        Path | None, typer.Option("--bank", help="A bank to judge as it is, in place of clips")
    ] = None,
    pairs: Annotated[
        Path | None,
        typer.Option(
            help="CSV file with the columns locomotion, action, truth, aligned, group, example, claim; only the first "
            "two must be filled"
        ),
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Baseline clip; default: the one with the most typical stride")
    ] = None,
    posture: Annotated[
        list[Posture] | None,
        typer.Option(help="Also judge the bank's splice with this posture; may be given several times"),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for scores.json and index.html")] = None,
) -> None:
    """Prints how close splices are to the truth."""
    forms = [*FORMS, *(Form("splice", form.value) for form in posture or [])]
    if bank_folder and (clips or baseline):
        raise SettingsError("--bank was given with CLIPS or --baseline", mend="A bank is judged as it is")
    with tempfile.TemporaryDirectory() as folder:
        bank = Bank.open(bank_folder) if bank_folder else bank_of(clips, baseline, Path(folder))
        evaluator = Evaluator(bank)
        is_built_in = clips is None and has_built_in_clips(bank)
        kind, bounds = ("built-in", BUILT_IN) if is_built_in else ("real", REAL)
        file = pairs or (PAIRS if clips else EXAMPLES if is_built_in else None)
        grid = [judge(evaluator, pair, forms) for pair in (grid_pairs() if is_built_in else ())]
        listed = [judge(evaluator, pair, forms) for pair in (read_pairs(file) if file else pairs_of_bank(bank))]
        scores = [one.score for one in grid or listed]
        clip_scores = [score_clip(bank, clip.name) for clip in bank.clips]
        judged_targets = targets(scores, clip_scores, bounds)
        claims = [claim_row(one.pair, claim_values(bank, one)) for one in listed if one.pair.claim]
        groups = {"action": by_part(scores, "action"), "locomotion": by_part(scores, "locomotion")}
        if not grid:
            names = dict.fromkeys(one.pair.group for one in listed)
            groups = {"group": {name: [one.score for one in listed if one.pair.group == name] for name in names}}
        means = [
            (f"Mean error / mean error of the naive splice, by {part}", *means_table(some))
            for part, some in groups.items()
            if any(one.truth for one in scores)
        ]
        show("Pairs", *pair_table(scores))
        for mean in means:
            show(*mean)
        show("Clips", *clip_table(clip_scores))
        claim_columns = [*(form.label for form in forms), "truth, or else the locomotion", "the action alone"]
        claim_cells = [[*map(Cell, (f"{row.example} ({row.pair})", row.label, *row.values))] for row in claims]
        show("Examples", ["example", "measure", *claim_columns], claim_cells)
        rows = [
            [Cell(one.what), Cell(one.found, "good" if one.met else "bad"), Cell(one.wanted)] for one in judged_targets
        ]
        show("Targets", ["measure", "measured", "target"], rows)
        if out is None:
            return
        drawn = [*(listed if file else ()), *sorted(grid if file else listed, key=_badness)[: -WORST_DRAWN - 1 : -1]]
        numbers = document(bank, (*grid, *listed), clip_scores, judged_targets)
        out.mkdir(parents=True, exist_ok=True)
        (out / "scores.json").write_text(json.dumps(numbers), encoding="utf-8")
        write_report(
            out / "index.html",
            title=f"Splices of {kind} motion compared with the truth",
            subtitle=f"bank {bank.digest}, baseline {bank.baseline.clip}, {len(bank.clips)} clips",
            pairs=scores,
            clips=clip_scores,
            judged=judged_targets,
            errors={one.score.name: errors_over_time(bank, one) for one in drawn if one.truth is not None},
            rate=STRIP_RATE,
            claims=claims,
            claim_columns=claim_columns,
            pictures=[
                picture(bank, one.score, one.pair.example, one.truth, one.splices, expanded=number < OPEN)
                for number, one in enumerate(drawn)
            ],
            grid=bool(grid),
            means=means,
        )
        console.print(f"Report: {out / 'index.html'}")
        if bank_folder:
            console.print(
                f"In the viewer: motionsplice serve {bank_folder} --report {out / 'scores.json'}", soft_wrap=True
            )


def _badness(one: Judged) -> tuple[float, float]:
    score = one.score.of(OURS)
    return score.ratio or 0.0, score.mismatch or 0.0


def show(title: str, columns: Sequence[str], rows: Sequence[Sequence[Cell]]) -> None:
    """Prints a table."""
    colours = {"good": "green", "fair": "yellow", "bad": "red", "": ""}
    table = Table(title=title)
    for number, column in enumerate(columns):
        table.add_column(column, justify="right" if number else "left", no_wrap=True)
    for row in rows:
        table.add_row(*(f"[{colours[cell.grade]}]{cell.text}[/]" if cell.grade else cell.text for cell in row))
    console.print(table)


if __name__ == "__main__":
    run(lambda: typer.run(main))
