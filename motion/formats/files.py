"""The kinds of motion files: finds the clips in them, parses them, and writes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats import asf_amc, bvh
from motionsplice.motion.formats.fold import Nodes
from motionsplice.motion.formats.gltf import reader as gltf_reader
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.formats.scene import nodes_of
from motionsplice.motion.roles import (
    NOTHING_GIVEN,
)

GLTF = (".glb", ".gltf", ".vrm", ".vrma")
WRITERS: Mapping[str, Callable[[Clip], bytes]] = {".bvh": bvh.dump_bvh, ".glb": dump_glb}
SUFFIXES = (".amc", ".bvh", *GLTF)


class Parsed(NamedTuple):
    """What a file says: its joints over time, frames per second, and perhaps its unit (metres), roles and notes.

    up: the axis that is up by the format's definition, None if the format does not define it.
    """

    nodes: Nodes
    rate: float
    unit: float | None = None
    roles: Mapping[str, str] = NOTHING_GIVEN  # type: ignore[assignment]
    notes: tuple[str, ...] = ()
    up: str | None = None


def clip_files(folder: Path) -> list[Path]:
    """Returns the motion files in a folder, in order of name."""
    return sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES)


def clips_in(path: Path) -> dict[str, str | None]:
    """Returns the names of the clips in a file, each with its animation; None for a file that holds one motion.

    A glTF file with several animations holds a clip `file:animation` for each. Raises FormatError.
    """
    names = _animations(path)
    return {clip_name(path, name if len(names) > 1 else None): name for name in names} or {path.stem: None}


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


def clip_name(path: Path, animation: str | None) -> str:
    return path.stem if animation is None else f"{path.stem}:{animation}"


def _animations(path: Path) -> list[str]:
    return gltf_reader.animation_names(read_bytes(path)) if path.suffix.lower() in GLTF else []


def parse(path: Path, animation: str | None, root: str | None = None) -> Parsed:
    """Returns what a file says: of several skeletons the one with the joint `root`, else the largest.

    Raises FormatError.
    """
    suffix = path.suffix.lower()
    if path.is_dir():
        raise FormatError("this is a folder", mend=f"Give one file in it: {' or '.join(SUFFIXES)}")
    if suffix not in SUFFIXES:
        raise FormatError(f"unsupported file type {suffix!r}", mend=f"Convert it to {' or '.join(SUFFIXES)}")
    data = read_bytes(path)
    if suffix in GLTF:
        return _parse_gltf(path, data, animation, root)
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


def _parse_gltf(path: Path, data: bytes, animation: str | None, root: str | None) -> Parsed:
    names = gltf_reader.animation_names(data)
    if not names:
        raise FormatError("it has no animation", mend="Export the armature with its animation")
    if animation is None and len(names) > 1:
        problem = f"it has {len(names)} animations"
        raise FormatError(problem, mend=f"Choose one with --animation: {', '.join(names)}")
    scene = gltf_reader.read_scene(data, lambda name: read_bytes(_beside(path, name)), animation or names[0])
    nodes, notes = nodes_of(scene, root)
    return Parsed(nodes, scene.rate, 1.0, scene.roles, notes, up="y")


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
