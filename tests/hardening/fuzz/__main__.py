"""Fuzzes doors: `python -m tests.hardening.fuzz [DOOR ...] [--runs 200000] [--out build/hardening/fuzz]`.

Inputs are made by generators that know the grammar, from bytes that atheris (libFuzzer) changes so that they reach more
lines behind the door. Each must pass the door, or be refused by a typed error, within 1 s of processor time and 64 MiB
of memory plus 64 times its size (RLIMIT_AS). Anything else is a finding: its input is saved, and the exit status is 1.
An input that is made again is neither sent nor counted.
Needs the extra `fuzz`. For a BVH file, `passed the first line` means that it got further than the keyword HIERARCHY;
likewise for others. The coverage, of lines and branches, is that of the corpus. Counts go on from those of earlier runs
in the same folder; `--runs 0` only prints them. The last line about a door is its row in docs/hardening.md.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from motionsplice.cli import run
from motionsplice.motion.errors import SettingsError, did_you_mean
from tests.hardening.fuzz.door import DOORS
from tests.hardening.fuzz.harness import Tally
from tests.hardening.memory import IN_MEMORY

SHOWN = 12  # outcomes


def main(
    doors: Annotated[list[str] | None, typer.Argument(help=f"{', '.join(DOORS)}; all without it")] = None,
    runs: Annotated[int, typer.Option(min=0, help="Number of further inputs of each door")] = 200_000,
    out: Annotated[Path, typer.Option(help="Folder for the corpora and findings")] = Path("build/hardening/fuzz"),
) -> None:
    """Prints what came of the inputs."""
    if find_spec("atheris") is None:
        raise SettingsError("fuzzing needs the package atheris", mend="Run: pip install --editable '.[fuzz]'")
    bad = 0
    for door in doors or DOORS:
        if door not in DOORS:
            raise SettingsError(f"unknown door {door!r}", mend=did_you_mean(door, DOORS))
        tally, status = _fuzzed(door, out / door, runs)
        bad += len(tally.bad) + (status != 0)
        share = {name: getattr(tally, name) / max(1, tally.inputs) for name in ("passed_first", "passed")}
        print(
            f"{door}: {tally.inputs:,} inputs, {tally.repeated:,} more were made again, {share['passed_first']:.1%} "
            f"passed the first line, {share['passed']:.1%} the whole door, the slowest took {tally.slowest:.2f} s"
        )
        for outcome, count in tally.outcomes.most_common(SHOWN):
            print(f"  {count:>9,}  {outcome}")
        covered = _coverage(door, out / door / "corpus")
        for file, percent in covered.items():
            print(f"  {percent:>9}  {file}")
        for outcome, saved in tally.bad.items():
            print(f"  FOUND {outcome}, {saved}")
        if status:
            print(f"  FOUND the fuzzer ended with {status}, {out / door}/log")
        print(_row(door, tally, [float(percent.rstrip("%")) for percent in covered.values()]))
    sys.exit(bool(bad))


def _fuzzed(door: str, folder: Path, runs: int) -> tuple[Tally, int]:
    if not runs:
        return Tally.read(folder / "tally.json"), 0
    folder.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "tests.hardening.fuzz.guided", door, str(folder), str(runs)]
    with (folder / "log").open("wb") as log, tempfile.TemporaryDirectory(dir=IN_MEMORY) as own:
        empty, environment = Path(own) / "empty", os.environ | {"TMPDIR": own}  # the fuzzer ends without cleaning up
        empty.mkdir()
        done = subprocess.run([*command, str(empty)], stdout=log, stderr=log, env=environment, check=False)
    return Tally.read(folder / "tally.json"), done.returncode


def _row(door: str, tally: Tally, covered: list[float]) -> str:
    share = [f"{100.0 * count / max(1, tally.inputs):.1f} %" for count in (tally.passed_first, tally.passed)]
    speed, memory = tally.inputs / max(1e-9, tally.seconds), tally.memory / 2**20
    limits = f"{min(covered):.0f} to {max(covered):.0f} %"
    cells = (door, f"{tally.inputs:,}", f"{speed:,.0f}", *share, f"{tally.slowest:.2f}", f"{memory:.0f}", limits)
    return f"| {' | '.join(cells)} |"


def _coverage(door: str, corpus: Path) -> dict[str, str]:
    command = [sys.executable, "-m", "tests.hardening.fuzz.replay", door, str(corpus)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    covered: dict[str, str] = json.loads(done.stdout)
    return covered


if __name__ == "__main__":
    run(lambda: typer.run(main))
