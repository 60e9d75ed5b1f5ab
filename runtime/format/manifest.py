"""The manifest of a bank, read from untrusted bytes (docs/bank.md)."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import msgpack
import numpy as np

from motionsplice.motion.errors import BankError, MotionError
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.format.bounded import unpacked
from motionsplice.runtime.format.entries import BaselineEntry, ClipEntry, HandsEntry

FORMAT = "motionsplice bank"
VERSION = 7
MANIFEST = "manifest.msgpack"
LARGEST_MANIFEST = 64 * 2**20  # bytes; a clip takes about 500
DIGEST = re.compile("[0-9a-f]{32}")
NEARLY = 1e-3  # by which a number of a unit quaternion may exceed 1
REBUILD = "Build it again with `motionsplice precompute`"

ROWS, LOWER, UPPER, C, CELLS = "rows", "lower columns", "upper columns", "clips", "cells"
HAND_ROWS, HANDS, STANCES = "rows of hands", "columns of hands", "stances"
TABLES: Mapping[str, tuple[type, tuple[str | int, ...]]] = {
    "lower": (np.float32, (ROWS, LOWER)),
    "upper": (np.float32, (ROWS, UPPER)),
    "phase_of_frame": (np.float64, (ROWS,)),
    "frame_of_phase": (np.float32, (CELLS,)),
    "paths": (np.float64, (ROWS, 4)),
    "contacts": (np.uint8, (ROWS,)),
    "feet": (np.float32, (ROWS, 6)),
    "postures": (np.float64, (C, 2, 3)),
    "neutral": (np.int32, (C,)),
    "stances": (np.float32, (STANCES, UPPER)),
    "hands": (np.float32, (HAND_ROWS, HANDS)),
    "hand_frames": (np.float64, (HAND_ROWS, 2)),
}


Mark = tuple[int, int, int]


def mark_of(file: Path) -> Mark | None:
    """Returns inode, modification time and size, which change when a file is rewritten; None if it is missing."""
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns, found.st_size


@dataclass(frozen=True)
class Manifest:
    """The parsed manifest: `data` are the bytes of its file, `tables` the digests of tables by name.

    `mirror` is None if the rig has no mirror image.
    """

    data: bytes
    digest: str
    skeleton: Skeleton
    roles: Roles
    mirror: Mirror | None
    baseline: BaselineEntry
    clips: tuple[ClipEntry, ...]
    hands: tuple[HandsEntry, ...]
    tables: Mapping[str, str]

    @classmethod
    def read(cls, folder: Path) -> Manifest:
        """Reads the manifest of the bank in a folder. Raises BankError, naming the file."""
        return cls.parse(manifest_data(folder), str(folder / MANIFEST))

    @classmethod
    def parse(cls, data: bytes, file: str) -> Manifest:
        """Parses the bytes of a manifest. Raises BankError, naming the file."""
        try:
            digest, body = _body(data, file)
            tables = {name: _digest(name, body["tables"][name]) for name in TABLES}
            return cls(data, digest, *_contents(body), tables)
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError, msgpack.UnpackException) as error:
            problem = f"the manifest has a missing or invalid field ({type(error).__name__}: {error})"
            raise BankError(problem, file=file, mend=REBUILD) from None
        except BankError as error:
            raise error.within(file) from None
        except MotionError as error:
            raise BankError(error.problem, file=file, mend=REBUILD) from None


Entry = TypeVar("Entry", ClipEntry, BaselineEntry, HandsEntry, Roles)


def content_digest(data: bytes) -> str:
    """Returns the BLAKE2b digest (16 bytes, hex) by which a bank names and verifies its files."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def file_digest(file: Path) -> str:
    """Returns `content_digest` of a file without reading all of it into memory."""
    with file.open("rb") as data:
        return hashlib.file_digest(data, lambda: hashlib.blake2b(digest_size=16)).hexdigest()


def manifest_data(folder: Path) -> bytes:
    """Returns the bytes of the manifest of the bank in a folder. Raises BankError, naming the file."""
    file = folder / MANIFEST
    if not file.is_file():
        problem = "this folder is not a bank" if folder.is_dir() else "folder not found"
        raise BankError(problem, file=str(folder), mend="Build one with `motionsplice precompute CLIPS... --out BANK`")
    if file.stat().st_size > LARGEST_MANIFEST:
        raise BankError(f"the manifest is larger than {LARGEST_MANIFEST} bytes", file=str(file), mend=REBUILD)
    return file.read_bytes()


def _body(data: bytes, file: str) -> tuple[str, dict[str, Any]]:
    try:
        outer = unpacked(data)
        digest, packed, form, version = outer["digest"], outer["body"], outer["format"], outer["version"]
    except (ValueError, KeyError, TypeError, msgpack.UnpackException):
        raise BankError("the manifest is cut short or damaged", file=file, mend=REBUILD) from None
    if form != FORMAT or version != VERSION:
        problem = f"expected version {VERSION} of {FORMAT!r}, found version {version!r} of {form!r}"
        raise BankError(problem, file=file, mend=REBUILD)
    if not isinstance(packed, bytes) or content_digest(packed) != digest:
        raise BankError("the manifest was altered: its digest does not match", file=file, mend=REBUILD)
    body = unpacked(packed)
    if not isinstance(body, dict):
        raise BankError("the manifest is not a map", file=file, mend=REBUILD)
    return digest, body


def _contents(
    body: dict[str, Any],
) -> tuple[Skeleton, Roles, Mirror | None, BaselineEntry, tuple[ClipEntry, ...], tuple[HandsEntry, ...]]:
    rig = body["skeleton"]
    names = tuple(rig["names"])
    if not _fits(names, tuple, str):
        raise BankError("the manifest has a joint name that is not text", mend=REBUILD)
    skeleton = Skeleton(
        names=names,
        parents=np.array(rig["parents"], np.int64),
        offsets=np.array(rig["offsets"], np.float64),
        end_parents=np.array(rig["end_parents"], np.int64),
        end_offsets=np.array(rig["end_offsets"], np.float64).reshape(-1, 3),
    )
    (roles,), (baseline,) = _entries(Roles, [body["roles"]]), _entries(BaselineEntry, [body["baseline"]])
    mirror = None if body["mirror"] is None else _mirror(body["mirror"], skeleton.joint_count)
    return skeleton, roles, mirror, baseline, _entries(ClipEntry, body["clips"]), _entries(HandsEntry, body["hands"])


def _digest(table: str, digest: object) -> str:
    """Returns the digest of a table, after which its file is named. Raises BankError if it is none."""
    if not (isinstance(digest, str) and DIGEST.fullmatch(digest)):
        raise BankError(f"the manifest has the digest {digest!r:.40} of table {table!r}", mend=REBUILD)
    return digest


def _mirror(fields: Mapping[str, Any], joints: int) -> Mirror:
    twins, turns = tuple(fields["twins"]), [tuple(turn) for turn in fields["turns"]]
    fits = len(fields) == 2 and len(twins) == len(turns) == joints and _fits(twins, tuple, int)
    if not fits or not all(len(turn) == 4 and all(_fits(one, float) for one in turn) for turn in turns):
        raise BankError(f"the manifest's mirror does not fit {joints} joints", mend=REBUILD)
    mirror = Mirror(np.array(twins, np.int64), np.array(turns, np.float64))
    if np.abs(mirror.turns).max(initial=0.0) > 1.0 + NEARLY:
        raise BankError("the manifest's mirror has a turn that is no unit quaternion", mend=REBUILD)
    return mirror


def _entries(kind: type[Entry], records: Sequence[Mapping[str, Any]]) -> tuple[Entry, ...]:
    """Returns maps of the manifest as dataclasses `kind`. Raises BankError, naming the field, for a wrong type."""
    types, entries = _types_of(kind), []  # type: ignore[arg-type]  # a class has a hash, whatever its instances have
    for record in records:
        values: dict[str, Any] = {key: tuple(value) if type(value) is list else value for key, value in record.items()}
        entry = kind(**values)
        for name, (wanted, item) in types.items():
            if not _fits(value := getattr(entry, name), wanted, item):
                problem = f"the manifest has {name} = {value!r:.40}, expected {kind.__annotations__[name]}"
                raise BankError(problem, mend=REBUILD)
        entries.append(entry)
    return tuple(entries)


@cache
def _types_of(kind: type) -> dict[str, tuple[type, type | None]]:
    """Returns the type of each field of a dataclass, and that of the items of a tuple."""
    hints = get_type_hints(kind)
    return {name: (get_origin(hint) or hint, next(iter(get_args(hint)), None)) for name, hint in hints.items()}


def _fits(value: object, wanted: type, item: type | None = None) -> bool:
    """Whether a value, or each item of a tuple, has exactly this type; floats must be finite, a bool is not an int."""
    if item is not None:
        return type(value) is tuple and all(type(one) is item for one in value)
    return type(value) is wanted and (wanted is not float or math.isfinite(value))  # type: ignore[arg-type]
