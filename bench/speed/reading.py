"""Measures how fast motion files are read: `python -m bench.speed.reading [FILES] [--times 5] [--check]`.

Reads a long built-in walk as BVH and as GLB, and FILES, in turns. Prints the milliseconds to read a file, median and
slowest; the first time is not counted. --check exits with status 1 if a median misses its target: 100 ms a megabyte
of BVH, 30 ms a megabyte of GLB.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.findings import Findings
from motionsplice.cli import run
from motionsplice.motion.formats.files import clips_in, write_clip
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles

LONG = {"long.bvh": 120.0, "long.glb": 455.0}  # seconds of the walk, which give 5 and 10 MB
TARGETS = {".bvh": 100.0, ".glb": 30.0}  # milliseconds a megabyte


def main(
    files: Annotated[list[Path] | None, typer.Argument(help="Motion files to read too.")] = None,
    times: Annotated[int, typer.Option(min=1, help="How often each file is read.")] = 5,
    check: Annotated[bool, typer.Option("--check", help="Exit with status 1 if a target is missed.")] = False,
) -> None:
    """Prints how long files take to read."""
    findings = Findings("Reading files, milliseconds")
    with tempfile.TemporaryDirectory() as folder:
        built = [Path(folder) / name for name in LONG]
        for file, seconds in zip(built, LONG.values(), strict=True):
            clip = make("walk", seconds=seconds)
            write_clip(file, clip, find_roles(clip.skeleton))
        paths = [*built, *(files or [])]
        first = [next(iter(clips_in(path).values())) for path in paths]
        taken = np.array([[reading(*one) for one in zip(paths, first, strict=True)] for _ in range(times + 1)])[1:]
        for path, found in zip(paths, taken.T, strict=True):
            megabytes = path.stat().st_size / 1e6
            label = f"{path.name}, {megabytes:.1f} MB: median of {times}"
            target = round(megabytes * TARGETS[path.suffix]) if path in built else None
            findings.add(label, np.median(found), "{:.0f}", most=target)
            findings.add(f"{path.name}: slowest", found.max(), "{:.0f}")
    findings.show()
    for sentence in findings.missed:
        print(sentence)
    if check and findings.missed:
        raise typer.Exit(1)


def reading(path: Path, animation: str | None) -> float:
    """Returns the milliseconds that it takes to read an animation of a file."""
    began = time.perf_counter()
    read_clip(path, animation=animation)
    return 1000.0 * (time.perf_counter() - began)


if __name__ == "__main__":
    run(lambda: typer.run(main))
