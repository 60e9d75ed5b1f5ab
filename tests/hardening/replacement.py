"""A job that replaces a bank by another, and what must be found after it was disturbed at any moment."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from motionsplice.motion.errors import BankError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.alone import LOCK
from motionsplice.precompute.job.destination import CACHE
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST
from motionsplice.runtime.format.tables import TABLE_FOLDER

SECONDS, RATE = 2.5, 30.0
BEFORE, AFTER = ("walk", "run"), ("walk", "side_step")
BASELINE = "walk"


class DisturbedError(AssertionError):
    """A bank is neither the old one nor the new one, or more than a bank is left."""


def files_in(folder: Path) -> dict[str, bytes]:
    """Returns all files below a folder but locks, by their names in it."""
    files = (file for file in folder.rglob("*") if file.is_file() and file.name != LOCK)
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


@dataclass(frozen=True)
class Replacement:
    """Two folders of clips, and what a job that is left alone makes of the second.

    Attributes:
        clips: The clips of the new bank.
        before: The folder of the old bank, with its cache; empty if there is none.
        digests: The digests of the banks that may be found; None stands for no bank.
        reference: What the job leaves in place of `before`.
    """

    clips: Path
    before: Path
    digests: frozenset[str | None]
    reference: dict[str, bytes]

    @classmethod
    def make(cls, folder: Path, *, afresh: bool = False) -> Replacement:
        """Makes both banks below a folder. With `afresh` there is no old one."""
        for name, clips in (("old", BEFORE), ("new", AFTER)):
            (folder / name).mkdir(parents=True)
            for clip in clips:
                (folder / name / f"{clip}.bvh").write_bytes(dump_bvh(make(clip, seed=1, seconds=SECONDS, rate=RATE)))
        before, alone = folder / "before", folder / "alone"
        before.mkdir()
        old = None if afresh else build_bank([folder / "old"], before, baseline=BASELINE).digest
        shutil.copytree(before, alone)
        new = build_bank([folder / "new"], alone, baseline=BASELINE).digest
        return cls(folder / "new", before, frozenset({old, new}), files_in(alone))

    def begin(self, place: Path) -> None:
        """Puts the old bank in a place, instead of what is there; if there is none, not even a folder."""
        shutil.rmtree(place, ignore_errors=True)
        if None not in self.digests:
            shutil.copytree(self.before, place)

    def run(self, place: Path) -> str:
        """Runs the job, and returns the bank's digest. Raises MotionError."""
        return build_bank([self.clips], place, baseline=BASELINE).digest

    def check_whole(self, place: Path) -> str | None:
        """Returns the digest of the bank in a place. Raises DisturbedError unless it is old or new, and whole."""
        if not (place / MANIFEST).exists() and None in self.digests:
            return None
        try:
            digest = Bank.open(place).digest
        except BankError as error:
            raise DisturbedError(f"neither the old bank nor the new one: {error}") from None
        if digest not in self.digests:
            raise DisturbedError(f"another bank: {digest}")
        return digest

    def check_rerun(self, place: Path, *, torn: bool = False) -> None:
        """Runs the job again. Raises DisturbedError unless it leaves what an undisturbed job does.

        The old bank's tables may be gone already, as they are once the new bank is written twice. If `torn`, entries of
        the cache may be damaged: they are not synced, and are made again when they are needed.
        """
        self.run(place)
        found = files_in(place)
        new = Bank.open(place).manifest.tables.values()
        old = {name for name in self.reference if name.startswith(f"{TABLE_FOLDER}/") and Path(name).stem not in new}
        if missing := self.reference.keys() - found.keys() - old:
            raise DisturbedError(f"missing after another run: {sorted(missing)}")
        if more := found.keys() - self.reference.keys():
            raise DisturbedError(f"left over: {sorted(more)}")
        same = {name for name in found if found[name] == self.reference[name]}
        if changed := [name for name in found.keys() - same if not (torn and name.startswith(f"{CACHE}/"))]:
            raise DisturbedError(f"other bytes after another run: {changed}")
