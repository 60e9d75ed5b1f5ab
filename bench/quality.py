"""How near splices come to the truth: `python -m bench.quality [CLIPS] [--out FOLDER]`.

Over a folder of clips and a file of pairs; or without a folder over the built-in motions: all actions on all
locomotions and the thesis's examples (Heck's thesis, 4.4). Prints a table, and writes scores.json and index.html.
`bench/scores.py` says what each number is.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.claims import CLAIMS, Performance
from bench.clips import bank_of
from bench.measures import upper_body_errors
from bench.pair_list import Pair, grid_pairs, read_pairs, truth_of
from bench.report import Cell, ClaimRow, Picture, claim_row, clip_table, means_table, pair_table, picture, write_report
from bench.scores import Form, PairScore, Spliced, score_clip, score_pair, splice_pair
from bench.targets import BUILT_IN, OURS, REAL, targets
from motion.clip import Clip
from motion.quaternion import Floats
from runtime.bank import Bank
from runtime.evaluator import Evaluator

FORMS = (Form("naive"), Form("exact"), Form("splice"))
PAIRS, EXAMPLES = (Path(__file__).with_name(name) for name in ("pairs.csv", "examples.csv"))
SHOWN_RATE = 30.0  # frames per second of the strips that show errors over time
WORST_SHOWN = 4  # pairs of a grid that are drawn

console = Console(width=230)


@dataclass
class Findings:
    """What is gathered, pair by pair, for table, JSON and page."""

    scores: list[PairScore] = field(default_factory=list)
    errors: dict[str, dict[str, Floats]] = field(default_factory=dict)
    claims: list[ClaimRow] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; the built-in motions if not given")] = None,
    pairs: Annotated[Path | None, typer.Option(help="CSV: locomotion, action, truth or empty, example, claim")] = None,
    baseline: Annotated[str | None, typer.Option(help="Baseline clip; else the most typical stride")] = None,
    posture: Annotated[list[str] | None, typer.Option(help="Also judge the bank's splice with this posture")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for scores.json and index.html")] = None,
) -> None:
    """Prints how near splices come to the truth."""
    forms = [*FORMS, *(Form("splice", form) for form in posture or [])]  # type: ignore[arg-type]
    kind = "real" if clips else "built-in"
    with tempfile.TemporaryDirectory() as folder:
        bank = bank_of(clips, baseline, Path(folder))
        evaluator, found = Evaluator(bank), Findings()
        grid = [] if clips else grid_pairs()
        for pair in grid:
            gather(found, evaluator, pair, forms, drawn=False)
        gridded = list(found.scores)
        for pair in read_pairs(pairs or (PAIRS if clips else EXAMPLES)):
            gather(found, evaluator, pair, forms, drawn=out is not None)
        clip_scores = [score_clip(bank, clip.name) for clip in bank.clips]
        judged = gridded or found.scores
        reached = targets(judged, clip_scores, REAL if clips else BUILT_IN)
        show("Pairs", *pair_table(judged))
        parts = ("action", "locomotion") if gridded else ()
        means = [(f"Mean error over the naive splice's, by {part}", *means_table(gridded, part)) for part in parts]
        for mean in means:
            show(*mean)
        show("Clips", *clip_table(clip_scores))
        for row in found.claims:
            console.print(f"{row.example} ({row.pair}): {row.says}: {', '.join(row.values)}", highlight=False)
        columns = ["what", "found", "wanted"]
        show(
            "Targets",
            columns,
            [[Cell(t.what), Cell(t.found, "good" if t.met else "bad"), Cell(t.wanted)] for t in reached],
        )
        if out is not None:
            for one in sorted(gridded, key=lambda one: one.of(OURS).ratio or 0.0)[: -WORST_SHOWN - 1 : -1]:
                draw(found, evaluator, Pair(one.locomotion, one.action, f"{one.locomotion}+{one.action}"), forms, one)
            out.mkdir(parents=True, exist_ok=True)
            plain = {"pairs": [asdict(one) for one in found.scores], "clips": [asdict(one) for one in clip_scores]}
            plain["targets"] = [asdict(one) for one in reached]
            (out / "scores.json").write_text(json.dumps(plain, indent=1))
            write_report(
                out / "index.html",
                title=f"Splices of {kind} motion against the truth",
                subtitle=f"bank {bank.digest}, baseline {bank.baseline.clip}, {len(bank.clips)} clips",
                pairs=judged,
                clips=clip_scores,
                found=reached,
                errors=found.errors,
                rate=SHOWN_RATE,
                claims=found.claims,
                claim_columns=[*(form.label for form in forms), "truth, else locomotion", "the action itself"],
                pictures=found.pictures,
                grid=bool(gridded),
                means=means,
            )
            console.print(f"{out / 'index.html'}")


def gather(found: Findings, evaluator: Evaluator, pair: Pair, forms: Sequence[Form], *, drawn: bool) -> None:
    """Scores one pair, measures its claim, and draws it if asked."""
    truth = truth_of(pair, evaluator.bank)
    splices = [splice_pair(evaluator, pair.locomotion, pair.action, form) for form in forms]
    score = score_pair(evaluator, pair.locomotion, pair.action, truth, splices)
    found.scores.append(score)
    if pair.claim:
        found.claims.append(claim_row(pair, claimed(evaluator.bank, pair, truth, splices)))
    if drawn:
        draw(found, evaluator, pair, forms, score)


def claimed(bank: Bank, pair: Pair, truth: Clip | None, splices: Sequence[Spliced]) -> dict[str, float]:
    """The number of a pair's claim for each splice, the truth (else the locomotion itself) and the action itself."""
    phase, measure = bank.phase(pair.locomotion), CLAIMS[pair.claim].measure
    action = Performance(bank.motion(pair.action), bank.phase(pair.action), bank.roles)
    shown = {one.form.label: one.clip for one in splices} | {"truth": truth or bank.motion(pair.locomotion)}
    values = {
        label: measure(Performance(clip, phase[: clip.frame_count], bank.roles), action)
        for label, clip in shown.items()
    }
    return {**values, "action": measure(action, action)}


def draw(found: Findings, evaluator: Evaluator, pair: Pair, forms: Sequence[Form], score: PairScore) -> None:
    """Adds a pair's pictures and, if its truth is known, its errors over time."""
    bank, truth = evaluator.bank, truth_of(pair, evaluator.bank)
    splices = [splice_pair(evaluator, pair.locomotion, pair.action, form) for form in forms]
    title = f"{pair.example}: {score.name}" if pair.example else score.name
    found.pictures.append(picture(bank, score, title, truth, splices, shown=len(found.pictures) < 2))
    if truth is not None:
        found.errors[score.name] = {
            one.form.label: 100.0
            * upper_body_errors(one.clip.resampled(SHOWN_RATE), truth.resampled(SHOWN_RATE), bank.roles).mean(axis=1)
            for one in splices
        }


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
    typer.run(main)
