"""Motion files of any format -> clips."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats import asf_amc, bvh
from motionsplice.motion.formats.fold import Folded, Nodes, fold
from motionsplice.motion.formats.units import guess_unit, metres_per_unit
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import (
    ENDS,
    NOTHING_GIVEN,
    GivenRole,
    Roles,
    check_shape,
    common_ancestor,
    find_roles,
    limbs_by_name,
)

SUFFIXES = (".amc", ".bvh")
JUMP = 0.1  # radians, mean over joints: more after the first frame, and twice as much as elsewhere, is no motion

CHECKED_RATE = 10.0  # frames per second that show how a body is held


@dataclass(frozen=True, eq=False)
class Reading:
    """A clip, its roles, the metres that one of the file's units was taken for, and what is worth knowing.

    warnings tell what would spoil a splice if nothing is done about it; notes what was done to the file.
    """

    clip: Clip
    roles: Roles
    unit: float
    notes: tuple[str, ...]
    warnings: tuple[str, ...]


def read_clip(
    path: Path, *, skip_frames: int = 0, unit: str | None = None, roles: Mapping[str, GivenRole] = NOTHING_GIVEN
) -> Reading:
    """Reads a BVH or AMC file; an AMC file's skeleton is the ASF file beside it.

    `skip_frames` leading frames are left out; `unit` is the file's unit of length, for files that do not say it and
    whose legs do not show it; `roles` name joints that cannot be found by name. Raises MotionError naming the file.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # Skeleton and Clip refuse what is not finite
            return _read(path, skip_frames, unit, roles)
    except MotionError as error:
        raise error.within(str(path)) from None


def clip_files(folder: Path) -> list[Path]:
    """The files of a folder that are clips, in order of name."""
    return sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES)


def files_behind(path: Path) -> tuple[Path, ...]:
    """All files that `read_clip` reads for one. Raises FormatError if a skeleton is missing."""
    return (path, _skeleton_file(path)) if path.suffix.lower() == ".amc" and path.exists() else (path,)


def _read(path: Path, skip_frames: int, unit: str | None, given: Mapping[str, GivenRole]) -> Reading:
    nodes, rate, own_unit = _parse(path)
    if not 0 <= skip_frames < len(nodes.rotations):
        problem = f"{skip_frames} frames cannot be skipped of {len(nodes.rotations)}"
        raise FormatError(problem, mend="Choose a smaller --skip-frames")
    folded = fold(nodes, _root(nodes, given))
    roles = find_roles(folded.skeleton, given)
    notes = list(folded.notes)
    leg = roles.leg_length(folded.skeleton)
    if unit is not None:
        metres = metres_per_unit(unit)
    elif own_unit is not None:
        metres = own_unit
    else:
        metres, note = guess_unit(leg)
        notes.append(note)
    clip = _clip(path.stem, folded, rate, metres, skip_frames)
    posed = skip_frames == 0 and _starts_with_a_pose(clip.rotations)
    warnings = ("its first frame looks like a bind pose; --skip-frames 1 leaves it out",) if posed else ()
    if not given:
        some = slice(None, None, max(1, int(clip.rate / CHECKED_RATE)))
        check_shape(world_transforms(clip.skeleton, clip.root_positions[some], clip.rotations[some])[0], roles)
    return Reading(clip, roles, metres, tuple(notes), warnings)


def _parse(path: Path) -> tuple[Nodes, float, float | None]:
    """A file's nodes, frames per second, and metres per unit if it says so."""
    suffix = path.suffix.lower()
    if path.is_dir():
        raise FormatError("it is a folder", mend=f"Give one file of it, {' or '.join(SUFFIXES)}")
    if suffix not in SUFFIXES:
        raise FormatError(f"files of kind {suffix!r} cannot be read", mend=f"Give one of {', '.join(SUFFIXES)}")
    data = read_bytes(path)
    if suffix == ".bvh":
        return *bvh.parse(data), None
    asf = _skeleton_file(path)
    try:
        skeleton = asf_amc.parse_skeleton(read_bytes(asf))
    except MotionError as error:
        raise error.within(str(asf)) from None
    return *asf_amc.parse_motion(data, skeleton), skeleton.unit


def read_bytes(path: Path) -> bytes:
    """What is in a file. Raises FormatError if that is nothing."""
    if not path.exists():
        raise FormatError("there is no such file", file=str(path))
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FormatError(f"it cannot be read: {error.strerror}", file=str(path)) from None
    if not data or data.isspace():
        raise FormatError("the file is empty", file=str(path))
    return data


def _skeleton_file(path: Path) -> Path:
    """The ASF file of an AMC file: `16.asf` of `16_15.amc`, else the only one in the folder."""
    name = path.stem.rpartition("_")[0] or path.stem
    beside = sorted(file for file in path.parent.iterdir() if file.suffix.lower() == ".asf")
    named = [file for file in beside if file.stem == name] or beside
    if len(named) == 1:
        return named[0]
    problem = f"there is no {name}.asf beside it" + (f", and {len(beside)} others are" if beside else "")
    raise FormatError(f"its skeleton is missing: {problem}", mend=f"Put {name}.asf there")


def _root(nodes: Nodes, given: Mapping[str, GivenRole]) -> int:
    """Where legs and trunk part; the file's own root if names do not show it, which `find_roles` then reports."""
    found = limbs_by_name(nodes.names, given)
    return common_ancestor(nodes.parents, [found[role] for role in ENDS]) if set(ENDS) <= set(found) else 0


def _clip(name: str, folded: Folded, rate: float, metres: float, skip: int) -> Clip:
    positions = folded.root_positions[skip:] * metres
    return Clip(name, folded.skeleton.scaled(metres), rate, positions, folded.rotations[skip:])


def _starts_with_a_pose(rotations: Floats) -> bool:
    if len(rotations) < 4:
        return False
    first = quaternion.angle(rotations[0], rotations[1]).mean()
    if first <= JUMP:  # nearly always, and the rest need not be looked at
        return False
    return bool(first > 2.0 * np.max(quaternion.angle(rotations[1:-1], rotations[2:]).mean(axis=1)))
