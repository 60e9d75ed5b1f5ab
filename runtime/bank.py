"""A bank on disk: opened, verified and mapped. Immutable, and shared by all processes that map it (docs/bank.md)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import BankError, UnknownClipError, did_you_mean
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.format.checks import Tables, check_contents, check_fit
from motionsplice.runtime.format.contacts import Contact, contacts_of
from motionsplice.runtime.format.manifest import (
    MANIFEST,
    REBUILD,
    TABLES,
    BaselineEntry,
    ClipEntry,
    HandsEntry,
    Manifest,
)
from motionsplice.runtime.format.rows import Layout, TorsoRows

TABLE_FOLDER = "tables"


@dataclass(frozen=True, eq=False, repr=False)
class Bank:
    """All clips of a bank on one skeleton, and their tables (`TABLES` gives shapes and types)."""

    path: Path
    manifest: Manifest
    tables: Tables

    @classmethod
    def open(cls, path: str | Path, *, verify: bool = True) -> Bank:
        """Maps the bank in the folder `path`, after verifying the digest of everything in it.

        Without `verify` only what is needed is read, so a large bank opens at once; that its tables fit together is
        checked all the same, and no damaged number can lead a kernel astray, only spoil poses. `verify` may be called
        later. Raises BankError, naming file and mend, if it is not there, of another version, cut short or altered.
        """
        folder = Path(path)
        manifest = Manifest.read(folder)
        bank = cls(folder, manifest, {name: _map(name, file) for name, file in files(folder, manifest).items()})
        check_fit(manifest, bank.tables, str(folder / MANIFEST))
        if verify:
            bank.verify()
        return bank

    def verify(self) -> None:
        """Checks the digest and the numbers of every table, reading all of them. Raises BankError, naming the file."""
        check_contents(self.manifest, self.tables, self.files)

    @property
    def files(self) -> dict[str, Path]:
        """The file of each table."""
        return files(self.path, self.manifest)

    @property
    def digest(self) -> str:
        return self.manifest.digest

    @property
    def skeleton(self) -> Skeleton:
        return self.manifest.skeleton

    @property
    def roles(self) -> Roles:
        return self.manifest.roles

    @property
    def baseline(self) -> BaselineEntry:
        return self.manifest.baseline

    @property
    def clips(self) -> tuple[ClipEntry, ...]:
        return self.manifest.clips

    @property
    def hands(self) -> tuple[HandsEntry, ...]:
        """Which hands lie on which clips."""
        return self.manifest.hands

    @cached_property
    def layout(self) -> Layout:
        """Where in the rows of `lower` and `upper` what lies."""
        return Layout.of(self.skeleton, self.roles)

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {clip.name: number for number, clip in enumerate(self.clips)}

    def number(self, name: str) -> int:
        """The index of the clip called `name`; raises UnknownClipError with the near names if there is none."""
        try:
            return self._numbers[name]
        except KeyError:
            problem = f"the bank has no clip {name!r}"
            raise UnknownClipError(problem, mend=did_you_mean(name, self._numbers)) from None

    def clip(self, name: str) -> ClipEntry:
        """The entry of the clip called `name`; raises UnknownClipError."""
        return self.clips[self.number(name)]

    @cached_property
    def hand_clips(self) -> tuple[str, ...]:
        """The clips of hands by name; their numbers are their places here."""
        return tuple(sorted({one.name for one in self.hands}))

    @cached_property
    def _hand_numbers(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(self.hand_clips)}

    def hand_number(self, name: str) -> int:
        """The number of the hands called `name`; raises UnknownClipError with the near names if there are none."""
        if name in self._hand_numbers:
            return self._hand_numbers[name]
        problem = f"the bank has no hands {name!r}"
        if not self.hand_clips:
            raise UnknownClipError(problem, mend="Build it with `motionsplice precompute --hands BODY:HANDS`")
        raise UnknownClipError(problem, mend=did_you_mean(name, self.hand_clips))

    def hand_frames(self, name: str, body: str) -> NDArray[np.float64]:
        """Which frame [F, 2] of the hands called `name`, left and right, goes with each frame of the clip `body`.

        Raises UnknownClipError if the hands do not lie on that clip.
        """
        return np.asarray(self.tables["hand_frames"][self._hand_rows(name, body)[: self.clip(body).frame_count]])

    def hand_motion(self, name: str, body: str) -> NDArray[np.float64]:
        """Rotations [rows, n, 4] of the joints `layout.hands.joints`: the hands called `name` on the clip `body`.

        Raises UnknownClipError if they do not.
        """
        rows = self.tables["hands"][self._hand_rows(name, body)]
        return self.layout.hands.lanes(rows)[:, : len(self.layout.hands.joints)].astype(np.float64)

    def _hand_rows(self, name: str, body: str) -> NDArray[np.int64]:
        self.hand_number(name)
        for one in self.hands:
            if (one.name, one.body) == (name, body):
                return one.first_row + np.arange(self.clip(body).row_count)
        raise self.hands_not_aligned(name, body)

    def hands_not_aligned(self, name: str, body: str) -> UnknownClipError:
        """That hands do not lie on a clip, as an error."""
        bodies = ", ".join(repr(one.body) for one in self.hands if one.name == name)
        return UnknownClipError(f"hands {name!r} are not aligned to clip {body!r}", mend=f"They are to {bodies}")

    def neutral(self, name: str) -> str:
        """The name of the clip that the posture of `name` is relative to."""
        return self.clips[int(self.tables["neutral"][self.number(name)])].name

    def motion(self, name: str, *, seam: bool = False) -> Clip:
        """The clip called `name`, on the bank's skeleton, in its editable form; with `seam`, its seam after it."""
        rows = self._rows(name, seam)
        roots, rotations = self.layout.motion(self.tables["lower"][rows], self.tables["upper"][rows])
        return Clip(name, self.skeleton, self.clip(name).rate, roots, rotations)

    def torso(self, name: str, *, seam: bool = False) -> TorsoRows:
        """How the upper body of the clip called `name` sits on its root at each frame; with `seam`, its seam's too."""
        return self.layout.torso(self.tables["lower"][self._rows(name, seam)])

    def phase(self, name: str) -> NDArray[np.float64]:
        """The phase of each frame [F] of the clip called `name`, cycles of the baseline."""
        return np.asarray(self.tables["phase_of_frame"][self._rows(name, False)])

    def phase_at(self, name: str, seconds: float) -> float:
        """The phase of the clip called `name` at a time, cycles of the baseline; its ends' beyond them."""
        entry = self.clip(name)
        frame = min(max(seconds * entry.rate, 0.0), entry.frame_count - 1.0)
        before = min(int(frame), entry.frame_count - 2)
        here, after = self.tables["phase_of_frame"][entry.first_row + before :][:2]
        return float(here + (frame - before) * (after - here))

    def root_path(self, name: str, *, seam: bool = False) -> NDArray[np.float64]:
        """The way [F, 4] of the clip called `name`: x, height of the ground and z, metres, and heading, radians."""
        return np.asarray(self.tables["paths"][self._rows(name, seam)])

    def contacts(self, name: str) -> list[Contact]:
        """When which foot of the clip called `name` stands."""
        return contacts_of(self.tables["contacts"][self._rows(name, False)], self.clip(name).rate)

    def _rows(self, name: str, seam: bool) -> slice:
        entry = self.clip(name)
        return slice(entry.first_row, entry.first_row + (entry.row_count if seam else entry.frame_count))


def files(folder: Path, manifest: Manifest) -> dict[str, Path]:
    return {name: folder / TABLE_FOLDER / f"{Path(manifest.tables[name]).name}.npy" for name in TABLES}


def _map(name: str, file: Path) -> NDArray[Any]:
    try:
        return np.asarray(np.load(file, mmap_mode="r", allow_pickle=False))
    except FileNotFoundError:
        raise BankError(f"table {name!r} is missing", file=str(file), mend=REBUILD) from None
    except Exception as error:  # of a damaged header, whatever Python's parser raises
        raise BankError(f"table {name!r} is cut short or no table: {error}", file=str(file), mend=REBUILD) from None
