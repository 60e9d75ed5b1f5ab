"""Power cuts: `python -m tests.hardening.power_loss [--variants 20]`.

Records what a job that replaces a bank writes, renames and syncs. For each moment it makes the folders that a power cut
may then leave: names that were not synced are kept or lost, each by itself, and so are bytes, or torn. The bank must be
the old or the new one, whole, and at the end the new one; another run must leave what an undisturbed job does. Prints
how many folders were checked, and exits with 1 for a wrong one.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Annotated

import typer

from motionsplice.cli import run
from tests.hardening.disk import Disk, Operation, recorded
from tests.hardening.memory import IN_MEMORY
from tests.hardening.replacement import DisturbedError, Replacement

FIRST_INODE = 2**62  # of files that were there before


@dataclass
class Survivors:
    """What a power cut leaves of files.

    Attributes:
        names: The file of each path, by the file's number; None for a folder.
        contents: The bytes of each file, as they are known to be on the disk.
        changes: For each folder, the changes of names that may be lost.
        writes: For each file, by its number, the writes that may be lost.
    """

    names: dict[Path, int | None]
    contents: dict[int, bytes]
    changes: dict[Path, list[Operation]] = field(default_factory=dict)
    writes: dict[int, list[Operation]] = field(default_factory=dict)

    @classmethod
    def of(cls, place: Path) -> Survivors:
        """Returns the files of a folder, all of which are on the disk."""
        found = {file: number for number, file in enumerate(sorted(place.rglob("*")), FIRST_INODE)}
        contents = {number: file.read_bytes() for file, number in found.items() if file.is_file()}
        names = {file: number if file.is_file() else None for file, number in found.items()}
        return cls(names, contents)

    def do(self, one: Operation) -> None:
        """Does what an operation promises, and notes what it does not."""
        if one.kind == "write":
            self.writes.setdefault(one.inode, []).append(one)
        elif one.kind == "sync":
            self.contents[one.inode] = _written(self.contents.get(one.inode, b""), self.writes.pop(one.inode, []))
        elif one.kind == "sync names":
            for change in self.changes.pop(one.path, []):
                _rename(self.names, change)
        elif one.kind != "open":
            self.changes.setdefault(one.path.parent, []).append(one)

    def left(self, draw: Random, share: float) -> dict[Path, bytes | None]:
        """Returns the files that may be left, and None for folders. `share` of what is not synced is kept.

        A file whose folder is lost is among them, though nobody can reach it.
        """
        names = dict(self.names)
        for changes in self.changes.values():
            for change in changes:
                if draw.random() < share:
                    _rename(names, change)
        files: dict[Path, bytes | None] = {}
        for path, inode in names.items():
            if inode is None:
                files[path] = None
                continue
            writes = [one for one in self.writes.get(inode, []) if draw.random() < share]
            data = _written(self.contents.get(inode, b""), writes)
            files[path] = data[: draw.randrange(len(data))] if writes and draw.random() > share else data
        return files


def _rename(names: dict[Path, int | None], change: Operation) -> None:
    if change.kind == "remove":
        names.pop(change.path, None)
        return
    if change.source is not None:
        names.pop(change.source, None)
    names[change.path] = None if change.kind == "mkdir" else change.inode


def _written(data: bytes, writes: Sequence[Operation]) -> bytes:
    """Returns bytes after writes; what lies between is zeros."""
    whole = bytearray(data)
    for one in writes:
        whole.extend(bytes(max(0, one.place + len(one.data) - len(whole))))
        whole[one.place : one.place + len(one.data)] = one.data
    return bytes(whole)


def put(files: dict[Path, bytes | None], base: Path) -> None:
    """Makes the files and folders in `base` and in folders that are there."""
    reached = {base}
    for path in sorted(files):
        data = files[path]
        if path.parent not in reached:
            continue
        if data is None:
            reached.add(path)
            path.mkdir()
        else:
            path.write_bytes(data)


def check(replacement: Replacement, base: Path, variants: int, every: int = 1) -> int:
    """Checks `variants` folders after every `every`-th operation, and after the last. Returns how many.

    The first two are those in which nothing and all of what is not synced is left. Raises DisturbedError.
    """
    place, draw, count = base / "bank", Random(1), 0
    replacement.begin(place)
    left = Survivors.of(base)
    with recorded(Disk(base)) as disk:
        new = replacement.run(place)
    log = [one for one in disk.log if one.kind != "open"]
    for moment in range(len(log) + 1):
        for variant in range(variants if moment % every == 0 or moment == len(log) else 0):
            share = (0.0, 1.0)[variant] if variant < 2 else draw.random()
            shutil.rmtree(place, ignore_errors=True)
            put(left.left(draw, share), base)
            try:
                found = replacement.check_whole(place)
                if moment == len(log) and found != new:
                    raise DisturbedError("the new bank is lost though the job has ended")
                replacement.check_rerun(place, torn=True)
            except DisturbedError as error:
                last = log[moment - 1] if moment else None
                raise DisturbedError(f"after {moment} operations, {share:.0%} kept, the last {last}: {error}") from None
            count += 1
        if moment < len(log):
            left.do(log[moment])
    return count


def main(variants: Annotated[int, typer.Option(min=2, help="Folders after each operation")] = 20) -> None:
    """Checks replacing a bank, and making one where there was none."""
    for afresh in (False, True):
        with tempfile.TemporaryDirectory(dir=IN_MEMORY) as name:
            replacement, base = Replacement.make(Path(name) / "made", afresh=afresh), Path(name) / "base"
            base.mkdir()
            count = check(replacement, base, variants)
        which = "a first bank" if afresh else "another bank"
        print(f"{which}: {count} folders after power cuts, each with a whole bank or none")


if __name__ == "__main__":
    run(lambda: typer.run(main))
