"""Checks that the tables of a bank match its manifest and hold valid numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import BankError
from motionsplice.motion.parts import UPPER_BODY
from motionsplice.motion.role_names import OPTIONAL
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT
from motionsplice.runtime.format.entries import ClipEntry
from motionsplice.runtime.format.manifest import (
    CELLS,
    HAND_ROWS,
    HANDS,
    LOWER,
    REBUILD,
    ROWS,
    STANCES,
    TABLES,
    UPPER,
    C,
    Manifest,
    file_digest,
)
from motionsplice.runtime.format.rows import Layout

Tables = Mapping[str, NDArray[Any]]

FARTHEST = 1e6  # metres; poses are in 32 bits
MOST_AT_ONCE = 2**22  # numbers checked at a time, which bounds memory


def check_fit(manifest: Manifest, tables: Tables, file: str) -> None:
    """Checks that manifest and tables match, so that no kernel reads outside a table. Reads no table's contents.

    Raises BankError.
    """
    if problem := _misfit(manifest, tables):
        raise BankError(problem, file=file, mend=REBUILD)


def check_references(manifest: Manifest, tables: Tables, files: Mapping[str, Path]) -> None:
    """Checks the numbers of clips in the one table that has any, a small one. Raises BankError, naming the file."""
    if problem := _fault("neutral", tables["neutral"], manifest):
        raise BankError(f"table 'neutral' {problem}", file=str(files["neutral"]), mend=REBUILD)


def check_contents(manifest: Manifest, tables: Tables, files: Mapping[str, Path]) -> None:
    """Checks the digest and the numbers of every table. Reads all tables. Raises BankError, naming the file."""
    for name, file in files.items():
        if file_digest(file) != manifest.tables[name]:
            problem = f"table {name!r} was cut short or altered: its digest does not match"
            raise BankError(problem, file=str(file), mend=REBUILD)
        if problem := _fault(name, tables[name], manifest):
            raise BankError(f"table {name!r} {problem}", file=str(file), mend=REBUILD)


def _misfit(manifest: Manifest, tables: Tables) -> str:
    """Returns what does not match, as a sentence; empty if everything does."""
    roles, clips, joints = manifest.roles, manifest.clips, manifest.skeleton.joint_count
    named = {field.name: getattr(roles, field.name) for field in fields(roles) if field.name != "spine"}
    needed = [joint for role, joint in named.items() if role not in OPTIONAL]
    least, most = min([*needed, *roles.spine]), max([*named.values(), *roles.spine])
    if least < 0 or min(named.values()) < -1 or most >= joints or roles.pelvis < 1:
        return "a role refers to a joint that does not exist"
    if np.abs(manifest.skeleton.offsets).max() > FARTHEST:
        return f"a joint is more than {FARTHEST:g} m from its parent"
    if not clips or len({clip.name for clip in clips}) != len(clips):
        return "the bank has no clips, or two clips of the same name"
    if manifest.baseline.clip not in {clip.name for clip in clips}:
        return "the baseline is a clip that does not exist"
    layout = Layout.of(manifest.skeleton, roles)
    if manifest.mirror is not None and not _stays_in_half(manifest.mirror.twins, layout):
        return "the mirror has a twin in the other half of the body"
    rows_of = {clip.name: clip.row_count for clip in clips}
    if misfit := _misfit_of_hands(manifest, rows_of):
        return misfit
    sizes = {C: len(clips), LOWER: layout.lower.columns, UPPER: layout.upper.columns, HANDS: layout.hands.columns}
    sizes[HAND_ROWS] = sum(rows_of[one.body] for one in manifest.hands)
    sizes[ROWS] = sum(clip.row_count for clip in clips)
    sizes[STANCES] = sum(clip.stance >= 0 for clip in clips)
    sizes[CELLS] = sum(clip.cell_count for clip in clips)
    for name, (kind, shape) in TABLES.items():
        table, wanted = tables[name], tuple(sizes.get(str(axis), axis) for axis in shape)
        if table.dtype != kind or table.shape != wanted or not table.flags.c_contiguous:
            return f"table {name!r}: expected {np.dtype(kind)}{wanted}, found {table.dtype}{table.shape}"
        if not table.flags.aligned:
            return f"table {name!r} does not begin at a multiple of {table.itemsize} bytes in its file"
    row = cell = stance = 0
    for clip in clips:
        follows = clip.first_row == row and clip.first_cell == cell and clip.stance in (-1, stance)
        follows &= 0 <= clip.parts <= UPPER_BODY
        sized = 2 <= clip.frame_count <= clip.row_count and clip.cell_count >= 2 and 0.0 < clip.rate < 1e6
        if not (follows and sized and 0 <= clip.loop < clip.last_phase - clip.first_phase < 1e9):
            return f"the entry of clip {clip.name!r} does not match the tables"
        row, cell, stance = row + clip.row_count, cell + clip.cell_count, max(stance, clip.stance + 1)
    return _misfit_of_stretches(clips)


def _stays_in_half(twins: NDArray[np.int64], layout: Layout) -> bool:
    """Whether twins [J] lie in the same half of the body, so that a row can be mirrored."""
    halves = [{-1, layout.pelvis}, *({-1, *half.joints} for half in layout.halves.values())]
    return all(set(twins[list(half - {-1})].tolist()) <= half for half in halves)


def _misfit_of_stretches(clips: Sequence[ClipEntry]) -> str:
    by_name, seen = {clip.name: clip for clip in clips}, set[str]()
    for hybrid in clips:
        for name in hybrid.stretches:
            one = by_name.get(name)
            fits = one is not None and not one.stretches and 0.0 <= one.enters < one.leaves <= one.frame_count - 1.0
            if not fits or name in seen:
                return f"the stretch {name!r} of clip {hybrid.name!r} does not match the clips"
            seen.add(name)
    return ""


def _misfit_of_hands(manifest: Manifest, rows_of: Mapping[str, int]) -> str:
    row, pairs = 0, set[tuple[str, str]]()
    for one in manifest.hands:
        if one.body not in rows_of or one.first_row != row or (one.name, one.body) in pairs:
            return f"the entry of hands {one.name!r} on {one.body!r} does not match the tables"
        row, pairs = row + rows_of[one.body], pairs | {(one.name, one.body)}
    return ""


def _fault(name: str, table: NDArray[Any], manifest: Manifest) -> str:
    """Returns what is wrong with a table's numbers, as a predicate of its name; empty if nothing is."""
    flat, clips = table.reshape(-1), manifest.clips
    if name == "neutral":
        return "" if table.min() >= 0 and table.max() < len(clips) else "refers to a clip that does not exist"
    if name == "contacts" and table.max() > (LEFT_FOOT | RIGHT_FOOT):
        return "has bits of feet that do not exist"
    if not all(np.isfinite(flat[at : at + MOST_AT_ONCE]).all() for at in range(0, len(flat), MOST_AT_ONCE)):
        return "holds numbers that are not finite"
    if name == "phase_of_frame":
        ends = [(table[clip.first_row], table[clip.first_row + clip.row_count - 1]) for clip in clips]
        if np.abs(table).max() > 1e9 or ends != [(clip.first_phase, clip.last_phase) for clip in clips]:
            return "does not match the phases of the clips"
        rising = np.diff(table) > 0.0
        rising[[clip.first_row - 1 for clip in clips[1:]]] = True  # it may fall from one clip to the next
        if not rising.all():
            return "does not increase within a clip"
    return ""
