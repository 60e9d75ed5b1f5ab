"""Reads motion files of any supported format as clips."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats import asf_amc, bvh
from motionsplice.motion.formats.fold import Folded, Nodes, fold
from motionsplice.motion.formats.gltf import reader as gltf_reader
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.formats.scene import nodes_of
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

GLTF = (".glb", ".gltf", ".vrm", ".vrma")
WRITERS: Mapping[str, Callable[[Clip], bytes]] = {".bvh": bvh.dump_bvh, ".glb": dump_glb}
SUFFIXES = (".amc", ".bvh", *GLTF)
# The first frame is a bind pose if the step after it, in mean radians over the joints, exceeds this and is more than
# twice as large as any other step.
JUMP = 0.1

SHORTEST_LEG, LONGEST_LEG = 0.3, 2.5  # metres: with other legs, a glTF file is not in metres as it should be
CHECKED_RATE = 10.0  # frames per second at which the roles are checked against the motion


@dataclass(frozen=True, eq=False)
class Reading:
    """A motion file as it was read.

    Attributes:
        clip: The motion, in metres, with the root as joint 0.
        roles: The roles of the rig's joints.
        unit: The metres in the file's unit of length, as given, stated in the file, or guessed.
        notes: What was changed or assumed, such as joints left out or the unit guessed.
        warnings: Problems that will spoil a splice unless they are fixed, such as a leading bind pose.
    """

    clip: Clip
    roles: Roles
    unit: float
    notes: tuple[str, ...]
    warnings: tuple[str, ...]


class Parsed(NamedTuple):
    """What a file says: its joints over time, frames per second, and perhaps its unit (metres), roles and notes."""

    nodes: Nodes
    rate: float
    unit: float | None = None
    roles: Mapping[str, str] = NOTHING_GIVEN  # type: ignore[assignment]
    notes: tuple[str, ...] = ()


def read_clip(
    path: str | PathLike[str],
    *,
    animation: str | None = None,
    skip_frames: int = 0,
    unit: str | None = None,
    roles: Mapping[str, GivenRole] = NOTHING_GIVEN,
) -> Reading:
    """Reads a BVH, AMC or glTF file (.glb, .gltf, .vrm, .vrma).

    The skeleton of an AMC file is the ASF file in the same folder: `16.asf` for `16_15.amc`, or else the only one.
    Joints above the root, at which legs and trunk branch, are folded into its motion; joints that do not descend
    from it are left out.

    Args:
        path: The file.
        animation: The name of the animation, for a glTF file that has several.
        skip_frames: The number of leading frames to leave out because they are not motion, such as a T-pose.
        unit: The file's unit of length: "m", "dm", "cm", "mm", "in", "cmu" (0.0254 / 0.45 m), or metres per unit as a
            number. None to use the one stated in the file, or else the one that gives the legs an adult's length.
        roles: Joint names by role, for joints that cannot be found by name; see `find_roles`.

    Returns:
        The clip, its roles, and notes and warnings for the user.

    Raises:
        FormatError: The file or its skeleton file is missing, malformed or of an unsupported type.
        ClipError: The motion is invalid, for example not finite.
        RoleError: The roles of the joints cannot be found.
        SettingsError: The unit or a role is unknown.

    Example:
        ```python
        from pathlib import Path
        from motionsplice import dump_bvh, read_clip
        from motionsplice.motion.procedural.library import make

        Path("walk.bvh").write_bytes(dump_bvh(make("walk"), unit=0.01))
        reading = read_clip(Path("walk.bvh"), unit="cm")
        print(reading.clip.frame_count, reading.clip.rate, reading.warnings)
        ```
    """
    path = Path(path)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # Skeleton and Clip reject numbers that are not finite
            return _read(path, animation, skip_frames, unit, roles)
    except MotionError as error:
        raise error.within(str(path)) from None


def clip_files(folder: Path) -> list[Path]:
    """Returns the motion files in a folder, in order of name."""
    return sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES)


def clips_in(path: Path) -> dict[str, str | None]:
    """Returns the names of the clips in a file, each with its animation; None for a file that holds one motion.

    A glTF file with several animations holds a clip `file:animation` for each. Raises FormatError.
    """
    names = _animations(path)
    return {_clip_name(path, name if len(names) > 1 else None): name for name in names} or {path.stem: None}


def write_clip(path: Path, clip: Clip) -> None:
    """Writes a clip as the kind of file that the name ends in, one of WRITERS."""
    path.write_bytes(WRITERS[path.suffix.lower()](clip))


def files_behind(path: Path) -> tuple[Path, ...]:
    """Returns all files that `read_clip` reads for `path`. Raises FormatError if a skeleton file is missing."""
    if path.suffix.lower() == ".amc" and path.exists():
        return path, _skeleton_file(path)
    if path.suffix.lower() == ".gltf" and path.exists():
        return path, *(_beside(path, name) for name in gltf_reader.buffer_files(read_bytes(path)))
    return (path,)


def _read(
    path: Path, animation: str | None, skip_frames: int, unit: str | None, given: Mapping[str, GivenRole]
) -> Reading:
    nodes, rate, own_unit, own_roles, own_notes = _parse(path, animation)
    given = {**own_roles, **given}
    if not 0 <= skip_frames < len(nodes.rotations):
        problem = f"cannot skip {skip_frames} of {len(nodes.rotations)} frames"
        raise FormatError(problem, mend="Choose a smaller --skip-frames")
    folded = fold(nodes, _root(nodes, given))
    roles = find_roles(folded.skeleton, given)
    notes = [*own_notes, *folded.notes]
    leg = roles.leg_length(folded.skeleton)
    if unit is not None:
        metres = metres_per_unit(unit)
    elif own_unit is not None and (path.suffix.lower() not in GLTF or SHORTEST_LEG <= own_unit * leg <= LONGEST_LEG):
        metres = own_unit
    else:
        metres, note = guess_unit(leg)
        notes.append(note)
    clip = _clip(_clip_name(path, animation), folded, rate, metres, skip_frames)
    posed = skip_frames == 0 and _starts_with_a_pose(clip.rotations)
    warnings = ("the first frame looks like a bind pose; leave it out with --skip-frames 1",) if posed else ()
    if not given:
        checked = slice(None, None, max(1, int(clip.rate / CHECKED_RATE)))
        check_shape(world_transforms(clip.skeleton, clip.root_positions[checked], clip.rotations[checked])[0], roles)
    return Reading(clip, roles, metres, tuple(notes), warnings)


def _clip_name(path: Path, animation: str | None) -> str:
    return path.stem if animation is None else f"{path.stem}:{animation}"


def _animations(path: Path) -> list[str]:
    return gltf_reader.animation_names(read_bytes(path)) if path.suffix.lower() in GLTF else []


def _parse(path: Path, animation: str | None) -> Parsed:
    """Returns what a file says. Raises FormatError."""
    suffix = path.suffix.lower()
    if path.is_dir():
        raise FormatError("this is a folder", mend=f"Give one file in it: {' or '.join(SUFFIXES)}")
    if suffix not in SUFFIXES:
        raise FormatError(f"unsupported file type {suffix!r}", mend=f"Convert it to {' or '.join(SUFFIXES)}")
    data = read_bytes(path)
    if suffix in GLTF:
        return _parse_gltf(path, data, animation)
    if animation is not None:
        raise FormatError(f"a {suffix} file has no animations by name", mend="Leave out --animation")
    if suffix == ".bvh":
        return Parsed(*bvh.parse(data))
    asf = _skeleton_file(path)
    try:
        skeleton = asf_amc.parse_skeleton(read_bytes(asf))
    except MotionError as error:
        raise error.within(str(asf)) from None
    return Parsed(*asf_amc.parse_motion(data, skeleton), skeleton.unit)


def _parse_gltf(path: Path, data: bytes, animation: str | None) -> Parsed:
    names = gltf_reader.animation_names(data)
    if not names:
        raise FormatError("it has no animation", mend="Export the armature with its animation")
    if animation is None and len(names) > 1:
        problem = f"it has {len(names)} animations"
        raise FormatError(problem, mend=f"Choose one with --animation: {', '.join(names)}")
    scene = gltf_reader.read_scene(data, lambda name: read_bytes(_beside(path, name)), animation or names[0])
    nodes, notes = nodes_of(scene)
    return Parsed(nodes, scene.rate, 1.0, scene.roles, notes)


def _beside(path: Path, name: str) -> Path:
    """Returns a file in the same folder or below it. Raises FormatError for others, which a hostile file may name."""
    file = path.parent / name
    if not file.resolve().is_relative_to(path.parent.resolve()):
        raise FormatError(f"it refers to {name!r}, outside its folder", mend="Put all its files into one folder")
    return file


def read_bytes(path: Path) -> bytes:
    """Returns the bytes of a file. Raises FormatError if it is missing, unreadable or empty."""
    if not path.exists():
        raise FormatError("no such file", file=str(path), mend="Check the path")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FormatError(f"the file cannot be read: {error.strerror}", file=str(path)) from None
    if not data or data.isspace():
        raise FormatError("the file is empty", file=str(path), mend="Export it again")
    return data


def _skeleton_file(path: Path) -> Path:
    """Returns the ASF file of an AMC file: `16.asf` for `16_15.amc`, or else the only one in the folder."""
    name = path.stem.rpartition("_")[0] or path.stem
    beside = sorted(file for file in path.parent.iterdir() if file.suffix.lower() == ".asf")
    named = [file for file in beside if file.stem == name] or beside
    if len(named) == 1:
        return named[0]
    others = f", but {len(beside)} other .asf files" if beside else ""
    raise FormatError(f"found no skeleton {name}.asf in its folder{others}", mend=f"Put {name}.asf beside the motion")


def _root(nodes: Nodes, given: Mapping[str, GivenRole]) -> int:
    """Returns the joint at which legs and trunk branch.

    If names do not show it, returns the file's own root; `find_roles` then reports what is missing.
    """
    found = limbs_by_name(nodes.names, given)
    return common_ancestor(nodes.parents, [found[role] for role in ENDS]) if set(ENDS) <= set(found) else 0


def _clip(name: str, folded: Folded, rate: float, metres: float, skip: int) -> Clip:
    positions = folded.root_positions[skip:] * metres
    return Clip(name, folded.skeleton.scaled(metres), rate, positions, folded.rotations[skip:])


def _starts_with_a_pose(rotations: Floats) -> bool:
    if len(rotations) < 4:
        return False
    first = quaternion.angle(rotations[0], rotations[1]).mean()
    if first <= JUMP:  # true of nearly all files, and then the other frames need not be read
        return False
    return bool(first > 2.0 * np.max(quaternion.angle(rotations[1:-1], rotations[2:]).mean(axis=1)))
