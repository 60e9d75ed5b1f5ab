"""Checks that the time per character and frame is constant: `python -m bench.speed.flatness [--out flatness.json]`.

Generated banks vary in one respect at a time: the length of clips, the number of clips, and, in one long clip, the time
since its start. All cases run interleaved in one process, and a straight line is fitted to the medians. Characters play
in two ways. The time since the start is measured in the second only.

everywhere   Characters play random pairs at random times. A larger bank is read in more places, so fewer of its rows
             are in the caches, and splices wait for memory.
same rows    Characters repeat a fixed number of splices that are spread over the whole bank. They read the same number
             of rows for each size of bank, few enough for the caches. So this measures the cost of the splice alone,
             and of finding its memory pages.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.generated import Size, generate
from bench.rounds import Slope, Work, fit_slope, interleaved
from bench.speed.workload import SETS, Scene, evaluation, request_sets
from motionsplice.cli import run
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import METHODS, Requests

CHARACTERS = 1000
POOL = 50  # splices that characters repeat
LENGTHS = (10, 20, 40, 80, 160, 320, 600)  # seconds, of LONG_CLIPS clips
COUNTS = (10, 40, 100, 400, 1000, 4000, 10_000)
LONG_CLIPS, SHORT = 8, 3.0
STARTS = tuple(range(0, 600, 50))  # seconds from the start of a clip of the greatest length
SPAN = 50.0  # seconds after each of STARTS in which characters play


@dataclass(frozen=True)
class Series:
    """Median seconds per character and frame at each x, and the line fitted to them; over log10(x) if `per_decade`."""

    name: str
    x_label: str
    per_decade: bool
    x: tuple[float, ...]
    splice: tuple[float, ...]
    naive: tuple[float, ...]
    slope: Slope


def main(
    rounds: Annotated[int, typer.Option(min=3, help="Rounds of each series")] = 100,
    out: Annotated[Path | None, typer.Option(help="JSON file for the results")] = None,
) -> None:
    """Prints the time per character and frame by clip length, by number of clips, and by time since the start."""
    series = measure(rounds, LENGTHS, COUNTS)
    console = Console(width=110)
    console.print(
        f"{CHARACTERS} characters per batch, medians of {rounds} interleaved rounds, ns per character and frame"
    )
    for one in series:
        console.print(series_table(one))
    console.print(slope_table(series))
    if out:
        out.write_text(json.dumps([asdict(one) for one in series], indent=1))


def measure(rounds: int, lengths: tuple[int, ...], counts: tuple[int, ...]) -> list[Series]:
    """Measures all series, with clips of `lengths` seconds and banks of `counts` clips."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        long = {float(s): generate(path / f"{s} s", Size(clips=LONG_CLIPS, seconds=s)) for s in lengths}
        many = {float(count): generate(path / f"{count}", Size(clips=count, seconds=SHORT)) for count in counts}
        return [
            _series(f"{subject}, {choice}", label, True, {x: (bank, play(bank)) for x, bank in banks.items()}, rounds)
            for subject, label, banks in (("clip length", "seconds", long), ("clips in the bank", "clips", many))
            for choice, play in (("everywhere", everywhere), ("same rows", same_rows))
        ] + [_since_start(long[float(lengths[-1])], rounds)]


def everywhere(bank: Bank) -> list[Requests]:
    """Requests for random pairs at random times."""
    return request_sets(bank, CHARACTERS, Scene())


def same_rows(bank: Bank) -> list[Requests]:
    """Requests in which all characters play one of POOL splices, which are spread over the bank."""
    return _repeated(request_sets(bank, POOL, Scene())[0])


def since(bank: Bank, start: float) -> list[Requests]:
    """Requests in which all characters play one of POOL splices, at times from `start` to `start` + SPAN."""
    pool = request_sets(bank, POOL, Scene())[0]
    pool.time[:] = start + SPAN * np.random.default_rng(2).random(POOL)
    return _repeated(pool)


def _repeated(pool: Requests) -> list[Requests]:
    draw = np.random.default_rng(1)
    return [Requests(pool.records[draw.integers(0, len(pool), CHARACTERS)]) for _ in range(SETS)]


def _since_start(bank: Bank, rounds: int) -> Series:
    duration = bank.clips[0].duration
    starts = [start for start in STARTS if start + SPAN <= duration]
    played = {start + 0.5 * SPAN: (bank, since(bank, float(start))) for start in starts}
    return _series("time since start", "seconds", False, played, rounds)


def _series(
    name: str, label: str, per_decade: bool, played: Mapping[float, tuple[Bank, list[Requests]]], rounds: int
) -> Series:
    work: dict[str, Work] = {}
    for x, (bank, sets) in played.items():
        evaluator = Evaluator(bank)
        work[f"splice {x}"] = evaluation(evaluator, sets)
        work[f"naive {x}"] = evaluation(evaluator, [_naive(one) for one in sets[::-1]])
        for one in sets:  # touches all pages before the clock runs
            evaluator.evaluate(one, evaluator.poses(len(one)))
    seconds = interleaved(work, rounds)
    xs = np.array(list(played), np.float64)
    splice, naive = (
        np.array([float(np.median(seconds[f"{method} {x}"])) / CHARACTERS for x in played])
        for method in ("splice", "naive")
    )
    scale: Callable[[Floats], Floats] = np.log10 if per_decade else np.asarray
    return Series(name, label, per_decade, tuple(xs), tuple(splice), tuple(naive), fit_slope(scale(xs), splice))


def _naive(requests: Requests) -> Requests:
    plain = Requests(requests.records.copy())
    plain.method[:] = METHODS["naive"]
    return plain


def series_table(series: Series) -> Table:
    """The table of a series, with a column for each x."""
    table = Table(title=f"{series.name[0].upper()}{series.name[1:]}", title_justify="left")
    table.add_column(series.x_label)
    for x in series.x:
        table.add_column(f"{x:,.0f}", justify="right")
    table.add_row("splice", *(f"{1e9 * y:,.0f}" for y in series.splice))
    table.add_row("naive", *(f"{1e9 * y:,.0f}" for y in series.naive))
    return table


def slope_table(series: list[Series]) -> Table:
    """The table of the slopes of splices, with their standard errors."""
    table = Table(title="Slope of the splice's time ± standard error", title_justify="left")
    for column in ("", "per", "ns", "relative to the median"):
        table.add_column(column, justify="right" if column else "left")
    for one in series:
        scale, per = (1.0, "factor of ten") if one.per_decade else (60.0, "minute")
        slope, error = 1e9 * scale * one.slope.slope, 1e9 * scale * one.slope.error
        part, part_error = 100.0 * scale * one.slope.relative, 100.0 * scale * one.slope.relative_error
        table.add_row(one.name, per, f"{slope:+.1f} ± {error:.1f}", f"{part:+.1f} % ± {part_error:.1f} %")
    return table


if __name__ == "__main__":
    run(lambda: typer.run(main))
