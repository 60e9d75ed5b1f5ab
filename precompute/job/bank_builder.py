"""Tables of all clips -> a bank on disk, whole or not at all (docs/bank.md)."""

from __future__ import annotations

import hashlib
import io
import os
import re
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.alignment.baseline import Baseline
from motionsplice.precompute.hands.rows import LaidHands
from motionsplice.precompute.preparation.prepared import PreparedClip, has_gait
from motionsplice.precompute.preparation.torso_offset import shoulder_motion, torso_offsets
from motionsplice.runtime.bank import TABLE_FOLDER
from motionsplice.runtime.format.manifest import (
    FORMAT,
    MANIFEST,
    TABLES,
    VERSION,
    BaselineEntry,
    ClipEntry,
    HandsEntry,
    content_digest,
)
from motionsplice.runtime.format.rows import Layout

OUR_TABLE = re.compile(r"[0-9a-f]{32}")  # what else lies in the folder is not ours to remove
OUR_PARTIAL = re.compile(rf"\.(table|{re.escape(MANIFEST)})\.\d+")
ABANDONED = 3600.0  # seconds after which no job is still writing a file
CELLS_PER_FRAME = 4  # of the inverse table: phase passes at least a quarter as fast as on average


def write_bank(
    path: Path,
    skeleton: Skeleton,
    roles: Roles,
    baseline: Baseline,
    prepared: Sequence[PreparedClip],
    hands: Sequence[LaidHands] = (),
) -> str:
    """Writes a bank of at least one clip, and hands on some of them, to the folder `path` and returns its digest.

    Tables are written and synced first; renaming the manifest makes the new bank current, so a reader sees the
    old bank or the new one. Tables that only the bank before the last one used are removed.
    """
    clips, layout = sorted(prepared, key=lambda one: one.name), Layout.of(skeleton, roles)
    laid = sorted(hands, key=lambda one: (one.name, one.body))
    laid_rows = sum(len(one.rows) for one in laid)
    folder, offsets = path / TABLE_FOLDER, _torso_offsets(clips)
    folder.mkdir(parents=True, exist_ok=True)
    rows, numbers = sum(len(one.phase) for one in clips), {one.name: number for number, one in enumerate(clips)}
    parts: dict[str, tuple[int, Iterable[NDArray[Any]]]] = {
        "lower": (rows, _rows("lower", layout, clips, offsets)),
        "upper": (rows, _rows("upper", layout, clips, offsets)),
        "phase_of_frame": (rows, (one.phase for one in clips)),
        "frame_of_phase": (CELLS_PER_FRAME * rows, (frame_of_phase(one.phase) for one in clips)),
        "paths": (rows, (one.path for one in clips)),
        "contacts": (rows, (one.contacts for one in clips)),
        "postures": (len(clips), (one.posture[None] for one in clips)),
        "neutral": (len(clips), (np.array([numbers[one.neutral]]) for one in clips)),
        "hands": (laid_rows, [np.zeros((0, layout.hands.columns)), *(one.rows for one in laid)]),
        "hand_frames": (laid_rows, [np.zeros((0, 2)), *(one.frames for one in laid)]),
    }
    digests = {name: write_table(folder, TABLES[name][0], *parts[name]) for name in TABLES}
    stride = BaselineEntry(baseline.name, baseline.start, baseline.end, baseline.loop, len(baseline.clouds))
    before = _tables_in_use(path / MANIFEST)
    digest = write_manifest(path, skeleton, roles, stride, _entries(clips, offsets), digests, _hands_entries(laid))
    for file in folder.glob("*.npy"):
        if OUR_TABLE.fullmatch(file.stem) and file.stem not in before | set(digests.values()):
            file.unlink()
    for file in (*path.iterdir(), *folder.iterdir()):
        if OUR_PARTIAL.fullmatch(file.name) and time.time() - file.stat().st_mtime > ABANDONED:
            file.unlink()  # of a job that was killed
    return digest


def write_manifest(
    path: Path,
    skeleton: Skeleton,
    roles: Roles,
    baseline: BaselineEntry,
    clips: Sequence[ClipEntry],
    tables: Mapping[str, str],
    hands: Sequence[HandsEntry] = (),
) -> str:
    """Makes written tables, digests by name, the bank in the folder `path`; returns the bank's digest."""
    body = {
        "skeleton": {
            "names": list(skeleton.names),
            "parents": skeleton.parents.tolist(),
            "offsets": skeleton.offsets.tolist(),
            "end_parents": skeleton.end_parents.tolist(),
            "end_offsets": skeleton.end_offsets.tolist(),
        },
        "roles": asdict(roles),
        "baseline": asdict(baseline),
        "clips": [asdict(clip) for clip in clips],
        "hands": [asdict(one) for one in hands],
        "tables": dict(tables),
    }
    packed = msgpack.packb(body)
    digest = content_digest(packed)
    manifest = {"format": FORMAT, "version": VERSION, "digest": digest, "body": packed}
    _write_synced(path / MANIFEST, msgpack.packb(manifest))
    return digest


def write_table(folder: Path, kind: type, length: int, parts: Iterable[NDArray[Any]]) -> str:
    """Writes parts, of `length` in all, end to end as a table, and returns its digest, after which it is named.

    No more than a part is held at once.
    """
    digest, partial = hashlib.blake2b(digest_size=16), folder / f".table.{os.getpid()}"
    with partial.open("wb") as sink:
        for number, part in enumerate(parts):
            data: NDArray[Any] = np.ascontiguousarray(part, kind)
            if number == 0:
                head, header = io.BytesIO(), np.lib.format.header_data_from_array_1_0(data)
                np.lib.format.write_array_header_1_0(head, header | {"shape": (length, *data.shape[1:])})
                sink.write(head.getvalue())
                digest.update(head.getvalue())
            sink.write(data.data)
            digest.update(data.data)
        sink.flush()
        os.fsync(sink.fileno())
    _put(partial, folder / f"{digest.hexdigest()}.npy")
    return digest.hexdigest()


def _rows(
    half: str, layout: Layout, clips: Sequence[PreparedClip], offsets: Mapping[str, Floats]
) -> Iterator[NDArray[np.float32]]:
    """Each clip's rows in a table."""
    for one in clips:
        rows = one.fetch(half)
        if one.name in offsets:
            rows = rows.copy()
            layout.set_torso_offsets(half, rows, offsets[one.name])
        yield rows


def _entries(clips: Sequence[PreparedClip], offsets: Mapping[str, Floats]) -> list[ClipEntry]:
    entries, row = [], 0
    for one in clips:
        rows, moved = len(one.phase), offsets.get(one.name)
        entries.append(
            ClipEntry(
                name=one.name,
                kind=one.kind,
                tags=one.tags,
                rate=one.rate,
                first_row=row,
                frame_count=one.frame_count,
                row_count=rows,
                first_cell=CELLS_PER_FRAME * row,
                cell_count=CELLS_PER_FRAME * rows,
                first_phase=float(one.phase[0]),
                last_phase=float(one.phase[-1]),
                cycles=one.alignment.cycles,
                loop=one.strides,
                gait=has_gait(one.alignment),
                mean_mismatch=one.alignment.mean_mismatch,
                worst_mismatch=one.alignment.worst_mismatch,
                shoulder_motion=0.0 if moved is None else shoulder_motion(moved[: one.frame_count]),
                warnings=one.warnings,
                notes=one.notes,
                source=one.source,
            )
        )
        row += rows
    return entries


def _hands_entries(laid: Sequence[LaidHands]) -> list[HandsEntry]:
    entries, row = [], 0
    for one in laid:
        said = one.settings
        entries.append(
            HandsEntry(
                name=one.name,
                body=one.body,
                first_row=row,
                rate=one.rate,
                hand=said.hand,
                wrist=said.wrist,
                pairs=tuple(str(pair) for pair in said.pairs),
                mismatch=one.mismatch,
                warnings=one.warnings,
                source=one.source,
            )
        )
        row += len(one.rows)
    return entries


def _torso_offsets(clips: Sequence[PreparedClip]) -> dict[str, Floats]:
    """The torso offsets [rows, 4] to its neutral of each clip that is not its own."""
    strides = {one.name: one.stride for one in clips}
    return {
        one.name: torso_offsets(one.fetch("upright"), one.phase, one.rate, strides[one.neutral])
        for one in clips
        if one.neutral != one.name
    }


def frame_of_phase(phase: Floats) -> Floats:
    """The inverse of a strictly increasing phase [F], in frames, on evenly spaced phases [CELLS_PER_FRAME F]."""
    grid = np.linspace(phase[0], phase[-1], CELLS_PER_FRAME * len(phase))
    return np.interp(grid, phase, np.arange(len(phase), dtype=np.float64))


def _tables_in_use(manifest: Path) -> set[str]:
    """The tables of the bank that is about to be replaced; none if there is no sound one."""
    try:
        return set(msgpack.unpackb(msgpack.unpackb(manifest.read_bytes())["body"])["tables"].values())
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return set()


def _write_synced(file: Path, data: bytes) -> None:
    partial = file.with_name(f".{file.name}.{os.getpid()}")
    with partial.open("wb") as sink:
        sink.write(data)
        sink.flush()
        os.fsync(sink.fileno())
    _put(partial, file)


def _put(partial: Path, file: Path) -> None:
    """Gives a file its name, so that it is there even after a power cut."""
    partial.replace(file)
    folder = os.open(file.parent, os.O_RDONLY)
    os.fsync(folder)
    os.close(folder)
