"""Measures how long a fresh process takes to start: `python -m bench.speed.first_call [--compile]`.

Prints the seconds of a process that imports the library, opens a bank, evaluates its first frame and warms up
characters, with kernels that were compiled before. With `--compile`, does the same with a copy of the package that
cannot be written to, as on a read-only file system. Its kernels are cached in NUMBA_CACHE_DIR: the first process
compiles them, and later processes load them.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.generated import Size, generate
from motionsplice.cli import run

PROJECT = Path(__file__).parents[2]
STEPS = ("start, import", "open bank", "make evaluator", "first frame", "second frame", "characters")
CHILD = """
import json, sys, time
marks = [float(sys.argv[2])]
def mark():
    marks.append(time.time())
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage
mark()
bank = Bank.open(sys.argv[1])
mark()
evaluator = Evaluator(bank)
mark()
for _ in range(2):
    evaluator.pose(Splice(bank.clips[0].name, bank.clips[-1].name), 0.5)
    mark()
if sys.argv[3:] == ["characters"]:
    Characters.warm(Stage(evaluator))
    mark()
print(json.dumps([after - before for before, after in zip(marks, marks[1:])]))
"""


def main(
    compiling: Annotated[
        bool, typer.Option("--compile", help="Also measure a read-only package, whose kernels are compiled first")
    ] = False,
    times: Annotated[
        int, typer.Option(min=1, help="Number of processes with compiled kernels, of which the median is printed")
    ] = 5,
) -> None:
    """Prints the seconds of each step of a fresh process."""
    with tempfile.TemporaryDirectory() as folder:
        path, rows = Path(folder), {}
        bank = generate(path / "bank", Size(clips=20)).path
        child(PROJECT, bank, {})
        rows["compiled before"] = median([child(PROJECT, bank, {}) for _ in range(times)])
        if compiling:
            sealed, cache = sealed_copy(path / "sealed"), {"NUMBA_CACHE_DIR": str(path / "cache")}
            rows["read-only, compiling"] = child(sealed, bank, cache)
            rows["read-only, compiled before"] = median([child(sealed, bank, cache) for _ in range(times)])
    table = Table(title="Start of a fresh process, seconds", title_justify="left")
    for column in ("", *STEPS, "total"):
        table.add_column(column, justify="right" if column else "left")
    for name, seconds in rows.items():
        table.add_row(name, *(f"{one:.4f}" for one in seconds), f"{sum(seconds):.2f}")
    Console(width=120).print(table)


def child(project: Path, bank: Path, environment: dict[str, str], *, characters: bool = True) -> list[float]:
    """Returns the seconds of STEPS in a new process that imports the packages from the folder `project`.

    Without `characters` it leaves out the last step, which compiles most of the kernels.
    """
    began = f"{time.time()}"
    done = subprocess.run(
        [sys.executable, "-c", CHILD, str(bank), began, *(["characters"] if characters else [])],
        cwd=project,
        env=os.environ | environment,
        check=True,
        capture_output=True,
        text=True,
    )
    seconds: list[float] = json.loads(done.stdout)
    return seconds


def sealed_copy(folder: Path) -> Path:
    """Copies the packages so that nobody, not even root, can cache kernels there: a file blocks each cache folder."""
    without = shutil.ignore_patterns("__pycache__", "precompute", "service", "commands", "pictures")
    shutil.copytree(PROJECT / "motionsplice", folder / "motionsplice", ignore=without)
    for room in (folder / "motionsplice" / "runtime").iterdir():
        if room.is_dir():
            (room / "__pycache__").touch()
    return folder


def median(processes: list[list[float]]) -> list[float]:
    """Returns the median over processes of each step."""
    return [sorted(one)[len(one) // 2] for one in zip(*processes, strict=True)]


if __name__ == "__main__":
    run(lambda: typer.run(main))
