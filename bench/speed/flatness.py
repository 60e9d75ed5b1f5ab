"""That time per character-frame is constant: `python -m bench.speed.flatness [--out flatness.json]`.

Generated banks, one thing changed at a time: how long clips are, how many there are, and, in one long clip, how far in
characters are. All run in turns, in rounds of one process, and a straight line is fitted through the medians. There are
two ways to play them, and the last is played in the second:

everywhere   characters play any pair at any time: a larger bank is touched in more places, so fewer of its rows are
             still in a cache, and a splice waits for memory.
same rows    characters play the same number of splices again and again, spread over the whole bank: as many rows are
             touched whatever the bank's size, few enough for the caches, so what is left is what a splice itself
             costs, and what finding its pages does.
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
POOL = 50  # splices that are played again and again
LENGTHS = (10, 20, 40, 80, 160, 320, 600)  # seconds, of LONG_CLIPS clips
COUNTS = (10, 40, 100, 400, 1000, 4000, 10_000)
LONG_CLIPS, SHORT = 8, 3.0
STARTS = tuple(range(0, 600, 50))  # seconds, in a clip of the longest
SPAN = 50.0  # seconds from a start on in which characters are


@dataclass(frozen=True)
class Series:
    """Median seconds per character-frame at each x, and the line through them: over log10 of x if `per_decade`."""

    name: str
    x_label: str
    per_decade: bool
    x: tuple[float, ...]
    splice: tuple[float, ...]
    naive: tuple[float, ...]
    slope: Slope


def main(
    rounds: Annotated[int, typer.Option(min=3)] = 100,
    out: Annotated[Path | None, typer.Option(help="JSON file of the results")] = None,
) -> None:
    """Prints time per character-frame against clip length, clips in the bank, and time since start."""
    series = measure(rounds, LENGTHS, COUNTS)
    console = Console(width=110)
    console.print(f"{CHARACTERS} characters a batch, medians of {rounds} interleaved rounds, ns per character-frame")
    for one in series:
        console.print(series_table(one))
    console.print(slope_table(series))
    if out:
        out.write_text(json.dumps([asdict(one) for one in series], indent=1))


def measure(rounds: int, lengths: tuple[int, ...], counts: tuple[int, ...]) -> list[Series]:
    """All series."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        long = {float(s): generate(path / f"{s} s", Size(clips=LONG_CLIPS, seconds=s)) for s in lengths}
        many = {float(count): generate(path / f"{count}", Size(clips=count, seconds=SHORT)) for count in counts}
        return [
            _series(f"{what}, {how}", label, True, {x: (bank, play(bank)) for x, bank in banks.items()}, rounds)
            for what, label, banks in (("clip length", "seconds", long), ("clips in the bank", "clips", many))
            for how, play in (("everywhere", everywhere), ("same rows", same_rows))
        ] + [_since_start(long[float(lengths[-1])], rounds)]


def everywhere(bank: Bank) -> list[Requests]:
    """Any pair at any time."""
    return request_sets(bank, CHARACTERS, Scene())


def same_rows(bank: Bank) -> list[Requests]:
    """POOL splices, spread over the bank, by as many characters as there are."""
    return _again_and_again(request_sets(bank, POOL, Scene())[0])


def since(bank: Bank, start: float) -> list[Requests]:
    """POOL splices, at times within SPAN from `start` on, by as many characters as there are."""
    pool = request_sets(bank, POOL, Scene())[0]
    pool.time[:] = start + SPAN * np.random.default_rng(2).random(POOL)
    return _again_and_again(pool)


def _again_and_again(pool: Requests) -> list[Requests]:
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
        for one in sets:  # so that no page is touched for the first time while the clock runs
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
    """One column for each x."""
    table = Table(title=f"{series.name[0].upper()}{series.name[1:]}", title_justify="left")
    table.add_column(series.x_label)
    for x in series.x:
        table.add_column(f"{x:,.0f}", justify="right")
    table.add_row("splice", *(f"{1e9 * y:,.0f}" for y in series.splice))
    table.add_row("naive", *(f"{1e9 * y:,.0f}" for y in series.naive))
    return table


def slope_table(series: list[Series]) -> Table:
    """The slopes of splices, with their standard errors."""
    table = Table(title="Slope of the splice's time, with its standard error", title_justify="left")
    for column in ("", "per", "ns", "part of the median"):
        table.add_column(column, justify="right" if column else "left")
    for one in series:
        scale, per = (1.0, "factor of ten") if one.per_decade else (60.0, "minute")
        slope, error = 1e9 * scale * one.slope.slope, 1e9 * scale * one.slope.error
        part, part_error = 100.0 * scale * one.slope.relative, 100.0 * scale * one.slope.relative_error
        table.add_row(one.name, per, f"{slope:+.1f} ± {error:.1f}", f"{part:+.1f} % ± {part_error:.1f} %")
    return table


if __name__ == "__main__":
    run(lambda: typer.run(main))
