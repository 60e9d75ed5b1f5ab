"""The banks that are served under load: the built-in motions."""

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
    """A bank of the built-in motions."""
    write_sample_clips(folder / "clips")
    build_bank([folder / "clips"], folder / "bank", baseline=BASELINE)
    return folder / "bank"


def another(folder: Path) -> Path:
    """The same with another run, in a folder beside it."""
    clips = folder / "other clips"
    shutil.copytree(folder / "clips", clips)
    (clips / "run.bvh").write_bytes(dump_bvh(make("run", seed=77, seconds=4.0)))
    build_bank([clips], folder / "other", baseline=BASELINE)
    return folder / "other"


def put(bank: Path, place: Path, *, damaged: bool = False) -> None:
    """Puts a bank in the place of another as the offline job does: tables first, the manifest last, by a rename."""
    for table in (bank / "tables").iterdir():
        if not (place / "tables" / table.name).exists():
            shutil.copy(table, place / "tables" / table.name)
    data = (bank / MANIFEST).read_bytes()
    (place / "manifest.new").write_bytes(data[: len(data) // 2] if damaged else data)
    (place / "manifest.new").replace(place / MANIFEST)


def names(bank: Path, kind: str) -> list[str]:
    """The clips of a kind."""
    return [clip.name for clip in Bank.open(bank).clips if clip.kind == kind]
