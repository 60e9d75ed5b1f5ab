"""Writes prepared clips as a bank on disk, whole or not at all (docs/bank.md)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import chain
from pathlib import Path

import msgpack
import numpy as np

from motionsplice.motion.errors import BankError, SkeletonError
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.parts import UPPER_BODY
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.alignment.baseline import Baseline
from motionsplice.precompute.hands.rows import LaidHands
from motionsplice.precompute.job.standing import StandingActions
from motionsplice.precompute.job.written import (
    Piece,
    make_folder,
    remove_others,
    tables_in_use,
    write_rows,
    write_synced,
)
from motionsplice.precompute.preparation.prepared import PreparedClip
from motionsplice.precompute.preparation.standing import Measured
from motionsplice.precompute.preparation.torso_offset import MeanStride, believed, shoulder_motion, torso_offsets
from motionsplice.runtime.format.entries import BaselineEntry, ClipEntry, HandsEntry
from motionsplice.runtime.format.manifest import FORMAT, LARGEST_MANIFEST, MANIFEST, TABLES, VERSION, content_digest
from motionsplice.runtime.format.packed_rows import packed_stance
from motionsplice.runtime.format.rows import Layout
from motionsplice.runtime.format.tables import TABLE_FOLDER

PIECE = 1024  # rows
MOST_NEUTRALS = 1000  # that are kept while clips are written, 2 kB each
CELLS_PER_FRAME = 4  # of the inverse table: the slope of phase is at least a quarter of its mean


def write_bank(
    path: Path,
    rig: Rig,
    baseline: Baseline,
    prepared: Mapping[str, PreparedClip],
    hands: Sequence[LaidHands] = (),
) -> str:
    """Writes a bank of at least one clip, with hands on some of them, to the folder `path` and returns its digest.

    Tables are written first, clip by clip: each clip is asked for twice, and may be forgotten then. Renaming the
    manifest makes the new bank current, so a reader sees either the old bank or the new one. The old bank's tables stay
    until the next bank is written; older tables are removed.
    """
    layout = Layout.of(rig.skeleton, rig.roles)
    laid = sorted(hands, key=lambda one: (one.name, one.body))
    laid_rows, stances = sum(len(one.rows) for one in laid), 0
    rows: dict[str, int] = {}
    for name in sorted(prepared):
        one = prepared[name]
        rows[name] = len(one.phase)
        stances += one.stands
    all_rows = sum(rows.values())
    lengths = dict.fromkeys(TABLES, all_rows) | {"frame_of_phase": CELLS_PER_FRAME * all_rows, "stances": stances}
    lengths |= dict.fromkeys(("postures", "neutral"), len(rows)) | dict.fromkeys(("hands", "hand_frames"), laid_rows)
    folder, clips = path / TABLE_FOLDER, _Clips(layout, prepared, list(rows), StandingActions(prepared, rig))
    make_folder(folder)
    digests = write_rows(folder, lengths, chain(_none_of(layout), _hands_rows(laid), clips.rows()))
    stride = BaselineEntry(baseline.name, baseline.start, baseline.end, baseline.loop, len(baseline.clouds))
    before = tables_in_use(path / MANIFEST)
    laid_entries = _hands_entries(laid)
    digest = write_manifest(path, rig.skeleton, rig.roles, _mirror(rig), stride, clips.entries, digests, laid_entries)
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

    Returns the bank's digest. Raises BankError if it cannot be written, or is larger than readers accept.
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
    }
    packer, packed = msgpack.Packer(), bytearray()
    packed += packer.pack_map_header(len(body) + 3)
    for key, value in body.items():
        packed += packer.pack(key) + packer.pack(value)
    for key, entries in (("clips", clips), ("hands", hands)):
        packed += packer.pack(key) + packer.pack_array_header(len(entries))
        for one in entries:  # thousands of maps at once would take several times the memory
            packed += packer.pack(vars(one))
    packed += packer.pack("tables") + packer.pack(dict(tables))
    return _put_manifest(path, bytes(packed))


def _put_manifest(path: Path, packed: bytes) -> str:
    digest = content_digest(packed)
    manifest = msgpack.packb({"format": FORMAT, "version": VERSION, "digest": digest, "body": packed})
    if len(manifest) > LARGEST_MANIFEST:
        problem = f"the manifest takes {len(manifest)} bytes, and readers take at most {LARGEST_MANIFEST}"
        raise BankError(problem, file=str(path / MANIFEST), mend="Split the clips into several banks")
    write_synced(path / MANIFEST, manifest)
    return digest


def _mirror(rig: Rig) -> Mirror | None:
    """Returns how a rig is mirrored, None if it is not symmetric."""
    pose = standing_pose(rig.skeleton, rig.roles) if rig.pose is None else rig.pose
    try:
        return Mirror.of(rig.skeleton, rig.roles, pose)
    except SkeletonError:
        return None


class _Clips:
    """The clips of a bank, turned one by one into rows of its tables and entries of its manifest."""

    def __init__(
        self, layout: Layout, clips: Mapping[str, PreparedClip], names: Sequence[str], standing: StandingActions
    ) -> None:
        self.entries: list[ClipEntry] = []
        self._layout, self._clips, self._standing = layout, clips, standing
        self._numbers = {name: number for number, name in enumerate(names)}
        self._neutral = lru_cache(MOST_NEUTRALS)(self._neutral_of)

    def rows(self) -> Iterator[Piece]:
        """Yields the rows of each clip in all tables but those of hands, and appends its entry."""
        row = stances = 0
        for name in self._numbers:
            one = self._clips[name]
            stands = self._standing.measured(one)
            turns = self._torso_offsets(one) if stands is None else stands.standing.turns
            yield from self._halves(one, turns, None if stands is None else stands.standing.usage)
            yield self._others(one)
            if stands is not None:
                yield {"stances": packed_stance(self._layout, stands.standing.stance)}
            self.entries.append(_entry(one, row, turns, stands, stances))
            row += len(one.phase)
            stances += stands is not None

    def _halves(self, one: PreparedClip, turns: Floats | None, usage: Floats | None) -> Iterator[Piece]:
        """Yields the rows of both halves with torso offsets and usage weights, as many as stay in a core's cache."""
        halves = {half: one.fetch(half) for half in ("lower", "upper")}
        for first in range(0, len(one.phase), PIECE):
            some = slice(first, first + PIECE)
            pieces = {half: rows[some] if turns is None else rows[some].copy() for half, rows in halves.items()}
            if turns is not None:
                for half, rows in pieces.items():
                    self._layout.set_torso_offsets(half, rows, turns[some])
            if usage is not None:
                self._layout.set_usage(pieces["upper"], usage[some])
            yield pieces

    def _others(self, one: PreparedClip) -> Piece:
        return {
            "phase_of_frame": one.phase,
            "frame_of_phase": frame_of_phase(one.phase),
            "paths": one.path,
            "contacts": one.contacts,
            "feet": one.feet,
            "postures": one.posture[None],
            "neutral": np.array([self._numbers[one.neutral]]),
        }

    def _torso_offsets(self, one: PreparedClip) -> Floats | None:
        """Returns the torso offsets [rows, 4] of a clip; None if it is its own neutral."""
        if one.neutral == one.name:
            return None
        stride, noise = self._neutral(one.neutral)
        return believed(_beyond(one, stride), one.frame_count, noise)

    def _neutral_of(self, name: str) -> tuple[MeanStride, float]:
        """Returns the mean stride of a neutral, and how much of what goes beyond it is noise, radians."""
        neutral = self._clips[name]
        return neutral.stride, shoulder_motion(_beyond(neutral, neutral.stride)[: neutral.frame_count])


def _beyond(one: PreparedClip, stride: MeanStride) -> Floats:
    return torso_offsets(one.fetch("upright"), one.phase, one.rate, stride, one.period)


def _none_of(layout: Layout) -> Iterator[Piece]:
    """Yields no rows of those tables that may be empty, but their columns."""
    yield {
        "stances": np.zeros((0, layout.upper.columns)),
        "hands": np.zeros((0, layout.hands.columns)),
        "hand_frames": np.zeros((0, 2)),
    }


def _hands_rows(laid: Sequence[LaidHands]) -> Iterator[Piece]:
    return ({"hands": one.rows, "hand_frames": one.frames} for one in laid)


def _entry(one: PreparedClip, row: int, turns: Floats | None, stands: Measured | None, stance: int) -> ClipEntry:
    rows = len(one.phase)
    return ClipEntry(
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
        shoulder_motion=0.0 if turns is None else shoulder_motion(turns[: one.frame_count]),
        repetition=one.repetition,
        stance=-1 if stands is None else stance,
        parts=UPPER_BODY if stands is None else stands.standing.parts,
        uses=() if stands is None else stands.uses,
        stretches=one.stretches,
        enters=0.0 if one.cut is None else one.cut.enters,
        leaves=0.0 if one.cut is None else one.cut.leaves,
        warnings=one.warnings if stands is None else (*one.warnings, *stands.warnings),
        notes=(*one.notes, *_notes(one, stands)),
        source=one.source,
    )


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


def frame_of_phase(phase: Floats) -> Floats:
    """Inverts a strictly increasing phase [F]: returns the frames at evenly spaced phases [CELLS_PER_FRAME F]."""
    grid = np.linspace(phase[0], phase[-1], CELLS_PER_FRAME * len(phase))
    return np.interp(grid, phase, np.arange(len(phase), dtype=np.float64))
