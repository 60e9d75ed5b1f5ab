"""Writes prepared clips as a bank on disk, whole or not at all (docs/bank.md)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

import msgpack
import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.parts import UPPER_BODY
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.alignment.baseline import Baseline
from motionsplice.precompute.hands.rows import LaidHands
from motionsplice.precompute.job.standing import standing_of
from motionsplice.precompute.job.written import Parts, remove_others, tables_in_use, write_synced, write_tables
from motionsplice.precompute.preparation.prepared import PreparedClip
from motionsplice.precompute.preparation.standing import Measured
from motionsplice.precompute.preparation.torso_offset import believed, shoulder_motion, torso_offsets
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
from motionsplice.runtime.format.packed_rows import packed_stance
from motionsplice.runtime.format.rows import Layout
from motionsplice.runtime.format.tables import TABLE_FOLDER

PIECE = 1024  # rows
CELLS_PER_FRAME = 4  # of the inverse table: the slope of phase is at least a quarter of its mean


def write_bank(
    path: Path,
    rig: Rig,
    baseline: Baseline,
    prepared: Sequence[PreparedClip],
    hands: Sequence[LaidHands] = (),
) -> str:
    """Writes a bank of at least one clip, with hands on some of them, to the folder `path` and returns its digest.

    Tables are written first. Renaming the manifest then makes the new bank current, so a reader sees either the old
    bank or the new one. The old bank's tables stay until the next bank is written; older tables are removed.
    """
    clips, layout = sorted(prepared, key=lambda one: one.name), Layout.of(rig.skeleton, rig.roles)
    laid = sorted(hands, key=lambda one: (one.name, one.body))
    laid_rows = sum(len(one.rows) for one in laid)
    standing = standing_of(clips, rig.skeleton, rig.roles)
    usages = {name: one.standing.usage for name, one in standing.items()}
    folder, offsets = path / TABLE_FOLDER, _torso_offsets(clips, standing)
    folder.mkdir(parents=True, exist_ok=True)
    rows, numbers = sum(len(one.phase) for one in clips), {one.name: number for number, one in enumerate(clips)}
    parts: dict[str, Parts] = {
        "lower": (rows, _rows("lower", layout, clips, offsets, {})),
        "upper": (rows, _rows("upper", layout, clips, offsets, usages)),
        "phase_of_frame": (rows, (one.phase for one in clips)),
        "frame_of_phase": (CELLS_PER_FRAME * rows, (frame_of_phase(one.phase) for one in clips)),
        "paths": (rows, (one.path for one in clips)),
        "contacts": (rows, (one.contacts for one in clips)),
        "feet": (rows, (one.feet for one in clips)),
        "postures": (len(clips), (one.posture[None] for one in clips)),
        "neutral": (len(clips), (np.array([numbers[one.neutral]]) for one in clips)),
        "stances": (len(standing), _stances(layout, standing)),
        "hands": (laid_rows, [np.zeros((0, layout.hands.columns)), *(one.rows for one in laid)]),
        "hand_frames": (laid_rows, [np.zeros((0, 2)), *(one.frames for one in laid)]),
    }
    digests = write_tables(folder, {name: parts[name] for name in TABLES})
    stride = BaselineEntry(baseline.name, baseline.start, baseline.end, baseline.loop, len(baseline.clouds))
    before = tables_in_use(path / MANIFEST)
    entries, laid_entries = _entries(clips, offsets, standing), _hands_entries(laid)
    digest = write_manifest(path, rig.skeleton, rig.roles, _mirror(rig), stride, entries, digests, laid_entries)
    remove_others(path, before | set(digests.values()))
    return digest


def write_manifest(
    path: Path,
    skeleton: Skeleton,
    roles: Roles,
    mirror: Mirror | None,
    baseline: BaselineEntry,
    clips: Sequence[ClipEntry],
    tables: Mapping[str, str],
    hands: Sequence[HandsEntry] = (),
) -> str:
    """Writes the manifest, which makes `tables` (digests by name) the bank in the folder `path`.

    Returns the bank's digest.
    """
    body = {
        "skeleton": {
            "names": list(skeleton.names),
            "parents": skeleton.parents.tolist(),
            "offsets": skeleton.offsets.tolist(),
            "end_parents": skeleton.end_parents.tolist(),
            "end_offsets": skeleton.end_offsets.tolist(),
        },
        "roles": vars(roles),
        "mirror": None if mirror is None else {"twins": mirror.twins.tolist(), "turns": mirror.turns.tolist()},
        "baseline": vars(baseline),
        "clips": [vars(clip) for clip in clips],
        "hands": [vars(one) for one in hands],
        "tables": dict(tables),
    }
    packed = msgpack.packb(body)
    digest = content_digest(packed)
    manifest = {"format": FORMAT, "version": VERSION, "digest": digest, "body": packed}
    write_synced(path / MANIFEST, msgpack.packb(manifest))
    return digest


def _mirror(rig: Rig) -> Mirror | None:
    """Returns how a rig is mirrored, None if it is not symmetric."""
    pose = standing_pose(rig.skeleton, rig.roles) if rig.pose is None else rig.pose
    try:
        return Mirror.of(rig.skeleton, rig.roles, pose)
    except SkeletonError:
        return None


def _rows(
    half: str,
    layout: Layout,
    clips: Sequence[PreparedClip],
    offsets: Mapping[str, Floats],
    usages: Mapping[str, Floats],
) -> Iterator[NDArray[np.float32]]:
    """Yields clips' rows of a table, with torso offsets and usage weights, in pieces that stay in a core's cache."""
    for clip in clips:
        rows, moved, usage = clip.fetch(half), offsets.get(clip.name), usages.get(clip.name)
        for first in range(0, len(rows), PIECE):
            some = slice(first, first + PIECE)
            piece = rows[some] if moved is None and usage is None else rows[some].copy()
            if moved is not None:
                layout.set_torso_offsets(half, piece, moved[some])
            if usage is not None:
                layout.set_usage(piece, usage[some])
            yield piece


def _stances(layout: Layout, standing: Mapping[str, Measured]) -> Iterator[NDArray[np.float32]]:
    """Yields the rows of the table `stances`."""
    yield np.zeros((0, layout.upper.columns), np.float32)
    for one in standing.values():
        yield packed_stance(layout, one.standing.stance)


def _entries(
    clips: Sequence[PreparedClip], offsets: Mapping[str, Floats], standing: Mapping[str, Measured]
) -> list[ClipEntry]:
    entries, row, stances = [], 0, {name: number for number, name in enumerate(standing)}
    for one in clips:
        rows, moved, stands = len(one.phase), offsets.get(one.name), standing.get(one.name)
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
                gait=one.alignment.has_gait,
                mean_mismatch=one.alignment.mean_mismatch,
                worst_mismatch=one.alignment.worst_mismatch,
                shoulder_motion=0.0 if moved is None else shoulder_motion(moved[: one.frame_count]),
                repetition=one.repetition,
                stance=stances.get(one.name, -1),
                parts=UPPER_BODY if stands is None else stands.standing.parts,
                uses=() if stands is None else stands.uses,
                stretches=one.stretches,
                enters=0.0 if one.cut is None else one.cut.enters,
                leaves=0.0 if one.cut is None else one.cut.leaves,
                warnings=one.warnings if stands is None else (*one.warnings, *stands.warnings),
                notes=(*one.notes, *_notes(one, stands)),
                source=one.source,
            )
        )
        row += rows
    return entries


def _notes(one: PreparedClip, stands: Measured | None) -> tuple[str, ...]:
    """Returns what the user should know of a standing action or a hybrid."""
    if one.stretches:
        turns = (
            f"{name} {'stands' if stretch.stands else 'walks'} from {stretch.begin:.1f} to {stretch.end:.1f} s"
            for name, stretch in zip(one.stretches, one.alignment.stretches, strict=True)
        )
        return (f"stands and walks by turns, so it plays as {', '.join(turns)}",)
    return () if stands is None else (stands.note,)


def _hands_entries(laid: Sequence[LaidHands]) -> list[HandsEntry]:
    entries, row = [], 0
    for one in laid:
        settings = one.settings
        entries.append(
            HandsEntry(
                name=one.name,
                body=one.body,
                first_row=row,
                rate=one.rate,
                hand=settings.hand,
                wrist=settings.wrist,
                pairs=tuple(str(pair) for pair in settings.pairs),
                mismatch=one.mismatch,
                warnings=one.warnings,
                source=one.source,
            )
        )
        row += len(one.rows)
    return entries


def _torso_offsets(clips: Sequence[PreparedClip], standing: Mapping[str, Measured]) -> dict[str, Floats]:
    """Returns torso offsets [rows, 4] by clip name, of standing actions and of clips that are not their own neutral."""
    by_name = {one.name: one for one in clips}

    def beyond(one: PreparedClip, neutral: PreparedClip) -> Floats:
        return torso_offsets(one.fetch("upright"), one.phase, one.rate, neutral.stride, one.period)

    @cache
    def noise(name: str) -> float:
        neutral = by_name[name]
        return shoulder_motion(beyond(neutral, neutral)[: neutral.frame_count])

    return {name: one.standing.turns for name, one in standing.items()} | {
        one.name: believed(beyond(one, by_name[one.neutral]), one.frame_count, noise(one.neutral))
        for one in clips
        if one.neutral != one.name and one.name not in standing
    }


def frame_of_phase(phase: Floats) -> Floats:
    """Inverts a strictly increasing phase [F]: returns the frames at evenly spaced phases [CELLS_PER_FRAME F]."""
    grid = np.linspace(phase[0], phase[-1], CELLS_PER_FRAME * len(phase))
    return np.interp(grid, phase, np.arange(len(phase), dtype=np.float64))
