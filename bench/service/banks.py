"""The banks that the benchmarks serve, built from the built-in motions."""

from __future__ import annotations

import shutil
from pathlib import Path

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.motion.samples import write_sample_clips
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST

BASELINE = "walk"


def built_in(folder: Path) -> Path:
    """Builds a bank of the built-in motions in `folder`, and returns its path."""
    write_sample_clips(folder / "clips")
    build_bank([folder / "clips"], folder / "bank", baseline=BASELINE)
    return folder / "bank"


def another(folder: Path) -> Path:
    """Builds the same bank with a different clip `run`, in another subfolder, and returns its path."""
    clips = folder / "other clips"
    shutil.copytree(folder / "clips", clips)
    (clips / "run.bvh").write_bytes(dump_bvh(make("run", seed=77, seconds=4.0)))
    build_bank([clips], folder / "other", baseline=BASELINE)
    return folder / "other"


def put(bank: Path, place: Path, *, damaged: bool = False) -> None:
    """Replaces the bank at `place` as the offline job does: writes tables first, and renames the manifest last.

    With `damaged`, the manifest is cut in half.
    """
    for table in (bank / "tables").iterdir():
        if not (place / "tables" / table.name).exists():
            shutil.copy(table, place / "tables" / table.name)
    data = (bank / MANIFEST).read_bytes()
    (place / "manifest.new").write_bytes(data[: len(data) // 2] if damaged else data)
    (place / "manifest.new").replace(place / MANIFEST)


def names(bank: Path, kind: str) -> list[str]:
    """Returns the names of the clips of a kind."""
    return [clip.name for clip in Bank.open(bank).clips if clip.kind == kind]
