"""Reads damaged motion files: `python -m bench.hostile [KIND ...] [--count 10000] [--jobs 2] [--files FOLDER]`.

Good files are damaged at random and read, each within 1 s of processor time and 256 MiB more memory. Each must be read,
or refused by a typed error. Prints how often each outcome came; any other exception, a warning, a crash, or a file that
takes longer or more memory is a finding: its file is saved, and the exit status is 1. The same seed gives the same
files. Good FBX files are only those in FOLDER; a crash of ufbx is not a finding, because its own process ends with it.

slowest      Seconds of processor time of the slowest file.
growth       MiB that the largest process has grown by, from its start to its end, over hundreds of files.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.findings import Findings
from bench.hostile.good_files import DAMAGES, good_files
from bench.hostile.reading import MOST_MEMORY, MOST_SECONDS, Tally, damaged, read_damaged
from motionsplice.cli import run
from motionsplice.motion.errors import SettingsError, did_you_mean

MIB = 2**20
SHOWN = 25  # outcomes


def main(
    kinds: Annotated[list[str] | None, typer.Argument(help=f"{', '.join(DAMAGES)}; all without it")] = None,
    count: Annotated[int, typer.Option(min=1, help="Number of damaged files of each kind")] = 10_000,
    jobs: Annotated[int, typer.Option(min=1, help="Number of processes at a time")] = 2,
    seed: Annotated[int, typer.Option(help="Number from which the damage is drawn")] = 0,
    files: Annotated[Path | None, typer.Option(help="Folder of further good files")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the files that were not read as they should be")] = Path("."),
) -> None:
    """Prints what came of damaged files."""
    missed = []
    for kind in kinds or [one for one in DAMAGES if good_files(one, files)]:
        if kind not in DAMAGES:
            raise SettingsError(f"unknown kind {kind!r}", mend=did_you_mean(kind, DAMAGES))
        goods = good_files(kind, files)
        if not goods:
            raise SettingsError(f"no good {kind} files", mend="Give a folder with some by --files")
        began = time.perf_counter()
        tally = read_damaged(kind, goods, seed, count, jobs)
        findings = Findings(f"{kind}: {count:,} damaged files, seed {seed}")
        findings.add("files per second", count / (time.perf_counter() - began), "{:.0f}")
        findings.add("slowest, s", tally.slowest, most=MOST_SECONDS)
        findings.add("growth, MiB", tally.growth / MIB, "{:.0f}", most=MOST_MEMORY / MIB)
        findings.add("wrong outcomes", len(tally.bad), "{:.0f}", most=0)
        findings.show()
        Console(width=120).print(_outcomes(tally))
        for outcome, number in tally.bad.items():
            for name, data in damaged(kind, goods, seed, number).files.items():
                (out / f"{kind}-{seed}-{number}-{name}").write_bytes(data)
            missed.append(f"{kind}, file {number}: {outcome}")
        missed += findings.missed
    for one in missed:
        print(one)
    sys.exit(bool(missed))


def _outcomes(tally: Tally) -> Table:
    table = Table("outcome", "files", "of all")
    for outcome, count in tally.outcomes.most_common(SHOWN):
        table.add_row(outcome, f"{count:,}", f"{count / tally.outcomes.total():.2%}")
    return table


if __name__ == "__main__":
    run(lambda: typer.run(main))
