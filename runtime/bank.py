"""A bank on disk: opened, verified and mapped. Immutable, and shared by all processes that map it (docs/bank.md)."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import msgpack
import numpy as np
from numpy.typing import NDArray

from motion.clip import Clip
from motion.errors import BankError, MotionError, UnknownClipError, did_you_mean
from motion.roles import Roles
from motion.skeleton import Skeleton

FORMAT = "motionsplice bank"
VERSION = 2
MANIFEST = "manifest.msgpack"
TABLE_FOLDER = "tables"
LARGEST_MANIFEST = 64 * 2**20  # bytes; a clip takes about 500

ROWS, J, P, C, CELLS = "rows", "joints", "points", "clips", "cells"
TABLES: Mapping[str, tuple[type, tuple[str | int, ...]]] = {
    "rotations": (np.float32, (ROWS, J, 4)),
    "root_positions": (np.float32, (ROWS, 3)),
    "phase_of_frame": (np.float64, (ROWS,)),
    "frame_of_phase": (np.float64, (CELLS,)),
    "upper_clouds": (np.float32, (ROWS, P, 3)),
    "posture_frames": (np.float32, (ROWS, 4)),
    "torso_offsets": (np.float32, (ROWS, 4)),
    "postures": (np.float64, (C, 2, 3)),
    "neutral": (np.int32, (C,)),
}


@dataclass(frozen=True)
class ClipEntry:
    """One clip of a bank: where its rows lie in the tables, and what its alignment was like.

    Its frame_count frames at `rate` per second are rows from first_row; after them come those of the seam, row_count in
    all, which lead back by `loop` whole strides (0: it cannot be repeated). Its inverse table is cell_count cells from
    first_cell. phase runs from first_phase to last_phase over all rows, in cycles of the baseline, of which its own
    frames take `cycles`. mean_mismatch and worst_mismatch are metres; shoulder_motion is how far its torso moves beyond
    its neutral's gait, radians.
    """

    name: str
    kind: str
    tags: tuple[str, ...]
    rate: float
    first_row: int
    frame_count: int
    row_count: int
    first_cell: int
    cell_count: int
    first_phase: float
    last_phase: float
    cycles: float
    loop: int
    mean_mismatch: float
    worst_mismatch: float
    shoulder_motion: float
    warnings: tuple[str, ...]
    notes: tuple[str, ...]
    source: str

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.frame_count - 1) / self.rate


@dataclass(frozen=True)
class BaselineEntry:
    """The stride that a bank is aligned to: from start to end of a clip, seconds, in `cells` cells.

    loop is how far its ends are apart, as a part of how far its halves are.
    """

    clip: str
    start: float
    end: float
    loop: float
    cells: int


@dataclass(frozen=True, eq=False)
class Bank:
    """All clips of a bank on one skeleton, and their tables (`TABLES` gives shapes and types)."""

    path: Path
    digest: str
    skeleton: Skeleton
    roles: Roles
    baseline: BaselineEntry
    clips: tuple[ClipEntry, ...]
    tables: Mapping[str, NDArray[Any]]

    @classmethod
    def open(cls, path: str | Path) -> Bank:
        """Maps the bank in the folder `path` after verifying the digest of everything in it.

        Raises BankError, naming file and mend, if it is not there, of another version, cut short or altered.
        """
        folder = Path(path)
        try:
            digest, body = _read_manifest(folder)
            return cls(folder, digest, *_contents(body), tables=_map_tables(folder, body))._checked()
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError, msgpack.UnpackException) as error:
            raise BankError(
                f"its manifest lacks or misstates something ({type(error).__name__}: {error})",
                file=str(folder / MANIFEST),
                mend=REBUILD,
            ) from None
        except BankError as error:
            raise error.within(str(folder / MANIFEST)) from None
        except MotionError as error:
            raise BankError(error.problem, file=str(folder / MANIFEST), mend=REBUILD) from None

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

    def neutral(self, name: str) -> str:
        """The name of the clip that the posture of `name` is relative to."""
        return self.clips[int(self.tables["neutral"][self.number(name)])].name

    def torso_offsets(self, name: str, *, seam: bool = False) -> NDArray[np.float64]:
        """What the torso of the clip called `name` does beyond its neutral's, at each frame [F, 4]."""
        return np.asarray(self.tables["torso_offsets"][self._rows(name, seam)], np.float64)

    def motion(self, name: str, *, seam: bool = False) -> Clip:
        """The clip called `name`, on the bank's skeleton, in its editable form; with `seam`, its seam after it."""
        entry, rows = self.clip(name), self._rows(name, seam)
        roots, rotations = (
            np.asarray(self.tables[table][rows], np.float64) for table in ("root_positions", "rotations")
        )
        return Clip(name, self.skeleton, entry.rate, roots, rotations)

    def phase(self, name: str) -> NDArray[np.float64]:
        """The phase of each frame [F] of the clip called `name`, cycles of the baseline."""
        return np.asarray(self.tables["phase_of_frame"][self._rows(name, False)])

    def _rows(self, name: str, seam: bool) -> slice:
        entry = self.clip(name)
        return slice(entry.first_row, entry.first_row + (entry.row_count if seam else entry.frame_count))

    def _checked(self) -> Bank:
        """Itself, if the parts fit each other, so that no kernel can be led out of a table. Raises BankError."""
        if problem := self._misfit():
            raise BankError(problem, file=str(self.path), mend=REBUILD)
        return self

    def _misfit(self) -> str:
        """What does not fit, as a sentence; empty if all does."""
        sizes = {J: self.skeleton.joint_count, C: len(self.clips), P: len(self.roles.upper_cloud)}
        sizes[ROWS] = sum(clip.row_count for clip in self.clips)
        sizes[CELLS] = sum(clip.cell_count for clip in self.clips)
        for name, (kind, shape) in TABLES.items():
            table, wanted = self.tables[name], tuple(sizes.get(str(axis), axis) for axis in shape)
            if table.dtype != kind or table.shape != wanted:
                return f"table {name!r} is {table.dtype}{table.shape}, not {np.dtype(kind)}{wanted}"
            if kind is not np.int32 and not np.isfinite(table).all():
                return f"table {name!r} holds numbers that are not finite"
        if not self.clips or len(self._numbers) != sizes[C]:
            return "it has no clips, or two of one name"
        if self.baseline.clip not in self._numbers:
            return "its baseline is a clip that is not there"
        row = cell = 0
        for clip in self.clips:
            follows = clip.first_row == row and clip.first_cell == cell
            sized = 2 <= clip.frame_count <= clip.row_count and clip.cell_count >= 2 and 0.0 < clip.rate < 1e6
            if not (follows and sized and 0 <= clip.loop < clip.last_phase - clip.first_phase):
                return f"clip {clip.name!r} does not fit the tables"
            row, cell = row + clip.row_count, cell + clip.cell_count
        phase = self.tables["phase_of_frame"]
        ends = [(phase[clip.first_row], phase[clip.first_row + clip.row_count - 1]) for clip in self.clips]
        if np.abs(phase).max() > 1e9 or ends != [(clip.first_phase, clip.last_phase) for clip in self.clips]:
            return "table 'phase_of_frame' does not fit the clips"
        rising = np.diff(self.tables["phase_of_frame"]) > 0.0
        rising[[clip.first_row - 1 for clip in self.clips[1:]]] = True  # from one clip to the next it may fall
        if not rising.all():
            return "table 'phase_of_frame' does not rise within a clip"
        neutral = self.tables["neutral"]
        if neutral.min() < 0 or neutral.max() >= sizes[C]:
            return "table 'neutral' names a clip that is not there"
        joints = [getattr(self.roles, field.name) for field in fields(self.roles) if field.name != "spine"]
        joints += self.roles.spine
        if min(joints) < -1 or max(joints) >= sizes[J] or self.roles.pelvis < 1:
            return "a role names a joint that is not there"
        return ""


REBUILD = "Build it again with `motionsplice precompute`"
Entry = TypeVar("Entry", ClipEntry, BaselineEntry, Roles)


def content_digest(data: bytes) -> str:
    """The digest by which a bank names and verifies its files."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def _read_manifest(folder: Path) -> tuple[str, dict[str, Any]]:
    file = folder / MANIFEST
    if not file.is_file():
        problem = "there is no bank here" if folder.is_dir() else "there is no such folder"
        raise BankError(problem, file=str(folder), mend="Build one with `motionsplice precompute CLIPS... --out BANK`")
    if file.stat().st_size > LARGEST_MANIFEST:
        raise BankError("the manifest is too large to be one", file=str(file), mend=REBUILD)
    try:
        outer = msgpack.unpackb(file.read_bytes())
        digest, packed, form, version = outer["digest"], outer["body"], outer["format"], outer["version"]
    except (ValueError, KeyError, TypeError, msgpack.UnpackException):
        raise BankError("the manifest is cut short or not a manifest", file=str(file), mend=REBUILD) from None
    if form != FORMAT or version != VERSION:
        problem = f"this is version {version!r} of {form!r}, and version {VERSION} of {FORMAT!r} is needed"
        raise BankError(problem, file=str(file), mend=REBUILD)
    if not isinstance(packed, bytes) or content_digest(packed) != digest:
        raise BankError("the manifest was altered: its digest does not fit", file=str(file), mend=REBUILD)
    body = msgpack.unpackb(packed)
    if not isinstance(body, dict):
        raise BankError("the manifest is not a map", file=str(file), mend=REBUILD)
    return digest, body


def _contents(body: dict[str, Any]) -> tuple[Skeleton, Roles, BaselineEntry, tuple[ClipEntry, ...]]:
    rig = body["skeleton"]
    names = tuple(rig["names"])
    if not _fits(names, tuple[str, ...]):
        raise BankError("the manifest names a joint by what is not text", mend=REBUILD)
    skeleton = Skeleton(
        names=names,
        parents=np.array(rig["parents"], np.int64),
        offsets=np.array(rig["offsets"], np.float64),
        end_parents=np.array(rig["end_parents"], np.int64),
        end_offsets=np.array(rig["end_offsets"], np.float64).reshape(-1, 3),
    )
    (roles,), (baseline,) = _entries(Roles, [body["roles"]]), _entries(BaselineEntry, [body["baseline"]])
    return skeleton, roles, baseline, _entries(ClipEntry, body["clips"])


def _entries(kind: type[Entry], said: Sequence[Mapping[str, Any]]) -> tuple[Entry, ...]:
    """Maps of the manifest as `kind`, a dataclass. Raises BankError, naming the field, if a type is another."""
    types, entries = get_type_hints(kind), []
    for one in said:
        values: dict[str, Any] = {key: tuple(v) if isinstance(v, list) else v for key, v in one.items()}
        entry = kind(**values)
        for name, wanted in types.items():
            if not _fits(value := getattr(entry, name), wanted):
                problem = f"the manifest gives {name} = {value!r:.40}, which is no {kind.__annotations__[name]}"
                raise BankError(problem, mend=REBUILD)
        entries.append(entry)
    return tuple(entries)


def _fits(value: object, wanted: Any) -> bool:
    """Whether a value is of a type as annotated: a bool is no int, and no float is infinite or NaN."""
    if get_origin(wanted) is tuple:
        return isinstance(value, tuple) and all(_fits(one, get_args(wanted)[0]) for one in value)
    return type(value) is wanted and (not isinstance(value, float) or math.isfinite(value))


def _map_tables(folder: Path, body: dict[str, Any]) -> dict[str, NDArray[Any]]:
    tables: dict[str, NDArray[Any]] = {}
    for name in TABLES:
        digest = str(body["tables"][name])
        file = folder / TABLE_FOLDER / f"{Path(digest).name}.npy"
        try:
            with file.open("rb") as data:
                found = hashlib.file_digest(data, lambda: hashlib.blake2b(digest_size=16)).hexdigest()
            if found != digest:
                problem = f"table {name!r} was cut short or altered: its digest does not fit"
                raise BankError(problem, file=str(file), mend=REBUILD)
            tables[name] = np.load(file, mmap_mode="r", allow_pickle=False)
        except FileNotFoundError:
            raise BankError(f"table {name!r} is missing", file=str(file), mend=REBUILD) from None
        except (OSError, ValueError) as error:
            raise BankError(f"table {name!r} cannot be read: {error}", file=str(file), mend=REBUILD) from None
    return tables
