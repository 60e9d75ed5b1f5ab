"""The manifest of a bank: what is in it, read from bytes that may be anything (docs/bank.md)."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import msgpack
import numpy as np

from motionsplice.motion.errors import BankError, MotionError
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton

FORMAT = "motionsplice bank"
VERSION = 5
MANIFEST = "manifest.msgpack"
LARGEST_MANIFEST = 64 * 2**20  # bytes; a clip takes about 500
REBUILD = "Build it again with `motionsplice precompute`"

ROWS, LOWER, UPPER, C, CELLS = "rows", "lower columns", "upper columns", "clips", "cells"
HAND_ROWS, HANDS = "rows of hands", "columns of hands"
TABLES: Mapping[str, tuple[type, tuple[str | int, ...]]] = {
    "lower": (np.float32, (ROWS, LOWER)),
    "upper": (np.float32, (ROWS, UPPER)),
    "phase_of_frame": (np.float64, (ROWS,)),
    "frame_of_phase": (np.float32, (CELLS,)),
    "paths": (np.float64, (ROWS, 4)),
    "contacts": (np.uint8, (ROWS,)),
    "postures": (np.float64, (C, 2, 3)),
    "neutral": (np.int32, (C,)),
    "hands": (np.float32, (HAND_ROWS, HANDS)),
    "hand_frames": (np.float64, (HAND_ROWS, 2)),
}


@dataclass(frozen=True)
class ClipEntry:
    """One clip of a bank: where its rows lie in the tables, and what its alignment was like.

    Its frame_count frames at `rate` per second are rows from first_row; after them come those of the seam, row_count in
    all, which lead back by `loop` whole strides (0: it cannot be repeated). Its inverse table is cell_count cells from
    first_cell. phase runs from first_phase to last_phase over all rows, in cycles of the baseline, of which its own
    frames take `cycles`; without `gait` that means little. mean_mismatch and worst_mismatch are metres; shoulder_motion
    is how far its torso moves beyond its neutral's gait, radians.
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
    gait: bool
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


@dataclass(frozen=True)
class HandsEntry:
    """A clip of hands on the body of a clip: where its rows lie, as many as the clip's.

    rate is the hands' own; hand is `left`, `right`, `both` (by one alignment) or `each` (by two); wrist, whether wrists
    and the twist of forearms are the hands' too; pairs are those that a user gave; mismatch is by how much phases of
    gestures differ, as a part of what any do; source is the digest of their file.
    """

    name: str
    body: str
    first_row: int
    rate: float
    hand: str
    wrist: bool
    pairs: tuple[str, ...]
    mismatch: float
    warnings: tuple[str, ...]
    source: str


Mark = tuple[int, int, int]


def mark_of(file: Path) -> Mark | None:
    """A number that changes whenever a file is written anew; None if it is not there."""
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns, found.st_size


@dataclass(frozen=True)
class Manifest:
    """All that a bank says of itself; tables are the digests of its tables by name, data the manifest file's bytes."""

    data: bytes
    digest: str
    skeleton: Skeleton
    roles: Roles
    baseline: BaselineEntry
    clips: tuple[ClipEntry, ...]
    hands: tuple[HandsEntry, ...]
    tables: Mapping[str, str]

    @classmethod
    def read(cls, folder: Path) -> Manifest:
        """The manifest of the bank in a folder. Raises BankError, naming the file and the mend."""
        file = folder / MANIFEST
        try:
            data = _read(folder)
            digest, body = _body(data, str(file))
            tables = {name: str(body["tables"][name]) for name in TABLES}
            return cls(data, digest, *_contents(body), tables)
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError, msgpack.UnpackException) as error:
            problem = f"its manifest lacks or misstates something ({type(error).__name__}: {error})"
            raise BankError(problem, file=str(file), mend=REBUILD) from None
        except BankError as error:
            raise error.within(str(file)) from None
        except MotionError as error:
            raise BankError(error.problem, file=str(file), mend=REBUILD) from None


Entry = TypeVar("Entry", ClipEntry, BaselineEntry, HandsEntry, Roles)


def content_digest(data: bytes) -> str:
    """The digest by which a bank names and verifies its files."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def file_digest(file: Path) -> str:
    """The same of a file, without the whole of it in memory."""
    with file.open("rb") as data:
        return hashlib.file_digest(data, lambda: hashlib.blake2b(digest_size=16)).hexdigest()


def _read(folder: Path) -> bytes:
    file = folder / MANIFEST
    if not file.is_file():
        problem = "there is no bank here" if folder.is_dir() else "there is no such folder"
        raise BankError(problem, file=str(folder), mend="Build one with `motionsplice precompute CLIPS... --out BANK`")
    if file.stat().st_size > LARGEST_MANIFEST:
        raise BankError("the manifest is too large to be one", file=str(file), mend=REBUILD)
    return file.read_bytes()


def _body(data: bytes, file: str) -> tuple[str, dict[str, Any]]:
    try:
        outer = msgpack.unpackb(data)
        digest, packed, form, version = outer["digest"], outer["body"], outer["format"], outer["version"]
    except (ValueError, KeyError, TypeError, msgpack.UnpackException):
        raise BankError("the manifest is cut short or not a manifest", file=file, mend=REBUILD) from None
    if form != FORMAT or version != VERSION:
        problem = f"this is version {version!r} of {form!r}, and version {VERSION} of {FORMAT!r} is needed"
        raise BankError(problem, file=file, mend=REBUILD)
    if not isinstance(packed, bytes) or content_digest(packed) != digest:
        raise BankError("the manifest was altered: its digest does not fit", file=file, mend=REBUILD)
    body = msgpack.unpackb(packed)
    if not isinstance(body, dict):
        raise BankError("the manifest is not a map", file=file, mend=REBUILD)
    return digest, body


def _contents(
    body: dict[str, Any],
) -> tuple[Skeleton, Roles, BaselineEntry, tuple[ClipEntry, ...], tuple[HandsEntry, ...]]:
    rig = body["skeleton"]
    names = tuple(rig["names"])
    if not _fits(names, tuple, str):
        raise BankError("the manifest names a joint by what is not text", mend=REBUILD)
    skeleton = Skeleton(
        names=names,
        parents=np.array(rig["parents"], np.int64),
        offsets=np.array(rig["offsets"], np.float64),
        end_parents=np.array(rig["end_parents"], np.int64),
        end_offsets=np.array(rig["end_offsets"], np.float64).reshape(-1, 3),
    )
    (roles,), (baseline,) = _entries(Roles, [body["roles"]]), _entries(BaselineEntry, [body["baseline"]])
    return skeleton, roles, baseline, _entries(ClipEntry, body["clips"]), _entries(HandsEntry, body["hands"])


def _entries(kind: type[Entry], said: Sequence[Mapping[str, Any]]) -> tuple[Entry, ...]:
    """Maps of the manifest as `kind`, a dataclass. Raises BankError, naming the field, if a type is another."""
    types: dict[str, tuple[type, type | None]] = {}
    for name, hint in get_type_hints(kind).items():
        of = get_args(hint)
        types[name] = (get_origin(hint) or hint, of[0] if of else None)
    entries = []
    for one in said:
        values: dict[str, Any] = {key: tuple(value) if type(value) is list else value for key, value in one.items()}
        entry = kind(**values)
        for name, (wanted, item) in types.items():
            if not _fits(value := getattr(entry, name), wanted, item):
                problem = f"the manifest gives {name} = {value!r:.40}, which is no {kind.__annotations__[name]}"
                raise BankError(problem, mend=REBUILD)
        entries.append(entry)
    return tuple(entries)


def _fits(value: object, wanted: type, item: type | None = None) -> bool:
    """Whether a value is of a type, and a tuple's of the item's: a bool is no int, and no float is infinite or NaN."""
    if item is not None:
        return type(value) is tuple and all(type(one) is item for one in value)
    return type(value) is wanted and (wanted is not float or math.isfinite(value))  # type: ignore[arg-type]
