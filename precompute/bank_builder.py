"""Tables of all clips -> a bank on disk, whole or not at all (docs/bank.md)."""

from __future__ import annotations

import io
import os
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from motion import quaternion
from motion.quaternion import Floats
from motion.roles import Roles
from motion.skeleton import Skeleton
from precompute.baseline import Baseline
from precompute.prepared import PreparedClip
from precompute.torso_offset import MeanStride, shoulder_motion, torso_offsets
from runtime.bank import TABLE_FOLDER
from runtime.manifest import FORMAT, MANIFEST, TABLES, VERSION, BaselineEntry, ClipEntry, content_digest
from runtime.rows import Layout, TorsoRows

OUR_TABLE = re.compile(r"[0-9a-f]{32}")  # what else lies in the folder is not ours to remove
OUR_PARTIAL = re.compile(rf"\.([0-9a-f]{{32}}\.npy|{re.escape(MANIFEST)})\.\d+")
ABANDONED = 3600.0  # seconds after which no job is still writing a file
CELLS_PER_FRAME = 4  # of the inverse table: phase passes at least a quarter as fast as on average


def write_bank(
    path: Path, skeleton: Skeleton, roles: Roles, baseline: Baseline, prepared: Sequence[PreparedClip]
) -> str:
    """Writes a bank of at least one clip to the folder `path` and returns its digest.

    Tables are written and synced first; renaming the manifest makes the new bank current, so a reader sees the
    old bank or the new one. Tables that only the bank before the last one used are removed.
    """
    clips = sorted(prepared, key=lambda one: one.clip.name)
    offsets = _torso_offsets(clips)
    tables = _tables(clips, offsets, Layout.of(skeleton, roles))
    folder = path / TABLE_FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    digests = {}
    for name, (kind, _) in TABLES.items():
        data = io.BytesIO()
        np.save(data, np.ascontiguousarray(tables[name], kind), allow_pickle=False)
        digests[name] = content_digest(data.getvalue())
        file = folder / f"{digests[name]}.npy"
        if not (file.exists() and content_digest(file.read_bytes()) == digests[name]):
            _write_synced(file, data.getvalue())
    stride = BaselineEntry(baseline.name, baseline.start, baseline.end, baseline.loop, len(baseline.clouds))
    before = _tables_in_use(path / MANIFEST)
    digest = write_manifest(path, skeleton, roles, stride, _entries(clips, offsets), digests)
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
        "tables": dict(tables),
    }
    packed = msgpack.packb(body)
    digest = content_digest(packed)
    manifest = {"format": FORMAT, "version": VERSION, "digest": digest, "body": packed}
    _write_synced(path / MANIFEST, msgpack.packb(manifest))
    return digest


def _entries(clips: Sequence[PreparedClip], offsets: Sequence[Floats]) -> list[ClipEntry]:
    entries, row = [], 0
    for one, turns in zip(clips, offsets, strict=True):
        phase, rows = one.seamed.phase, one.seamed.clip.frame_count
        entries.append(
            ClipEntry(
                name=one.clip.name,
                kind=one.kind,
                tags=one.tags,
                rate=float(one.clip.rate),
                first_row=row,
                frame_count=one.clip.frame_count,
                row_count=rows,
                first_cell=CELLS_PER_FRAME * row,
                cell_count=CELLS_PER_FRAME * rows,
                first_phase=float(phase[0]),
                last_phase=float(phase[-1]),
                cycles=one.alignment.cycles,
                loop=one.seamed.strides,
                mean_mismatch=one.alignment.mean_mismatch,
                worst_mismatch=one.alignment.worst_mismatch,
                shoulder_motion=shoulder_motion(turns[: one.clip.frame_count]),
                warnings=one.warnings,
                notes=one.notes,
                source=one.source,
            )
        )
        row += rows
    return entries


def _tables(clips: Sequence[PreparedClip], offsets: Sequence[Floats], layout: Layout) -> dict[str, NDArray[Any]]:
    numbers = {one.clip.name: number for number, one in enumerate(clips)}
    rows = [
        layout.pack(
            one.seamed.clip.root_positions,
            one.seamed.clip.rotations,
            TorsoRows(one.torso.clouds, one.torso.frames, turns),
        )
        for one, turns in zip(clips, offsets, strict=True)
    ]
    return {
        **{half: np.concatenate([one[half] for one in rows]) for half in ("lower", "upper")},
        "phase_of_frame": np.concatenate([one.seamed.phase for one in clips]),
        "frame_of_phase": np.concatenate([frame_of_phase(one.seamed.phase) for one in clips]),
        "postures": np.stack([one.posture for one in clips]),
        "neutral": np.array([numbers[one.neutral] for one in clips]),
    }


def _torso_offsets(clips: Sequence[PreparedClip]) -> list[Floats]:
    """Each clip's torso offsets [rows, 4] to its neutral; identities for one that is its own."""
    neutrals = {one.neutral for one in clips if one.neutral != one.clip.name}
    strides = {
        one.clip.name: MeanStride.of(one.torso.upright[: one.clip.frame_count], one.alignment.phase)
        for one in clips
        if one.clip.name in neutrals
    }
    return [
        np.tile(quaternion.IDENTITY, (one.seamed.clip.frame_count, 1))
        if one.neutral == one.clip.name
        else torso_offsets(one.torso.upright, one.seamed.phase, one.clip.rate, strides[one.neutral])
        for one in clips
    ]


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
    partial.replace(file)
    folder = os.open(file.parent, os.O_RDONLY)
    os.fsync(folder)
    os.close(folder)
