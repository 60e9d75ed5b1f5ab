"""The manifest of a bank, read from untrusted bytes (docs/bank.md)."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import msgpack
import numpy as np

from motionsplice.motion.errors import BankError, MotionError
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.format.bounded import unpacked

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


@dataclass(frozen=True)
class ClipEntry:
    """One clip of a bank: its rows in the tables, and the quality of its alignment.

    Attributes:
        name: Name of the clip.
        kind: `locomotion` or `action`.
        tags: Words of the user's choice.
        rate: Frames per second.
        first_row: Its first row in the tables.
        frame_count: Number of its own frames, which come first.
        row_count: Number of all its rows: its own frames, then the frames of its seam, which lead back to an earlier
            stride.
        first_cell: Its first cell in `frame_of_phase`.
        cell_count: Number of its cells.
        first_phase: Phase of its first row, cycles of the baseline.
        last_phase: Phase of its last row, cycles of the baseline.
        cycles: Cycles that its own frames take.
        loop: Whole strides by which the seam leads back; 0 if the clip cannot loop.
        gait: Whether its legs move like the baseline's. Without a gait, its phase means little.
        mean_mismatch: Mean distance of the alignment, metres.
        worst_mismatch: Largest distance of the alignment, metres.
        shoulder_motion: How far its torso moves beyond the gait of its neutral, radians.
        repetition: Mean distance of its upper body from itself a stride later, metres; 0 if it has less than a stride
            and a half, or no gait.
        stance: Row of its stance in the table `stances`; -1 if it is no standing action.
        parts: Bits of the parts that a standing action drives (`motion.parts`).
        uses: Names of the parts that a standing action uses.
        stretches: Names of the clips that a hybrid action plays one after another; empty for any other clip.
        enters: Real-valued frame at which a stretch of a hybrid takes over; 0 for any other clip.
        leaves: Real-valued frame at which it hands over to the next; 0 for any other clip.
        warnings: Problems found by the offline job.
        notes: Remarks of the offline job.
        source: Digest of the file.
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
    repetition: float
    stance: int
    parts: int
    uses: tuple[str, ...]
    stretches: tuple[str, ...]
    enters: float
    leaves: float
    warnings: tuple[str, ...]
    notes: tuple[str, ...]
    source: str

    @property
    def stands(self) -> bool:
        """Whether it is a standing action: without a gait, laid on a locomotion as what it adds to its stance."""
        return self.stance >= 0

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.frame_count - 1) / self.rate


@dataclass(frozen=True)
class BaselineEntry:
    """The stride that a bank is aligned to.

    Attributes:
        clip: Name of the clip.
        start: Seconds into the clip at which the stride starts.
        end: Seconds into the clip at which it ends.
        loop: Distance between the poses at the stride's ends, divided by the distance between poses half a stride
            apart.
        cells: Number of cells of its ring.
    """

    clip: str
    start: float
    end: float
    loop: float
    cells: int


@dataclass(frozen=True)
class HandsEntry:
    """A hands clip aligned to a clip of the bank.

    Attributes:
        name: Name of the hands clip.
        body: Name of the clip that it is aligned to.
        first_row: Its first row in the tables of hands; it has as many rows as the body.
        rate: Frames per second of the hands clip.
        hand: `left`, `right`, `both` (both hands by one alignment) or `each` (each hand by its own).
        wrist: Whether wrists and the twist of forearms come from the hands clip too, not fingers alone.
        pairs: Frame pairs that the user gave, as text.
        mismatch: Mean phase cost along the path divided by the mean over the band: 0 for identical gestures, about 1
            for unrelated ones.
        warnings: Problems found by the offline job.
        source: Digest of the file.
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
        return cls.parse(_read(folder), str(folder / MANIFEST))

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


def _read(folder: Path) -> bytes:
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
    types: dict[str, tuple[type, type | None]] = {}
    for name, hint in get_type_hints(kind).items():
        of = get_args(hint)
        types[name] = (get_origin(hint) or hint, of[0] if of else None)
    entries = []
    for record in records:
        values: dict[str, Any] = {key: tuple(value) if type(value) is list else value for key, value in record.items()}
        entry = kind(**values)
        for name, (wanted, item) in types.items():
            if not _fits(value := getattr(entry, name), wanted, item):
                problem = f"the manifest has {name} = {value!r:.40}, expected {kind.__annotations__[name]}"
                raise BankError(problem, mend=REBUILD)
        entries.append(entry)
    return tuple(entries)


def _fits(value: object, wanted: type, item: type | None = None) -> bool:
    """Whether a value, or each item of a tuple, has exactly this type; floats must be finite, a bool is not an int."""
    if item is not None:
        return type(value) is tuple and all(type(one) is item for one in value)
    return type(value) is wanted and (wanted is not float or math.isfinite(value))  # type: ignore[arg-type]
