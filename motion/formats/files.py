"""The kinds of motion files: finds the clips in them, parses them, and writes them."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats import asf_amc, bvh
from motionsplice.motion.formats.fbx import reader as fbx_reader
from motionsplice.motion.formats.gltf import reader as gltf_reader
from motionsplice.motion.formats.gltf.vrma import dump_vrma
from motionsplice.motion.formats.gltf.writer import dump_glb, dump_gltf
from motionsplice.motion.formats.legs import with_legs_in_place
from motionsplice.motion.formats.parsed import Parsed
from motionsplice.motion.formats.rest_pose import with_own_bind
from motionsplice.motion.formats.scene import Scene, nodes_of
from motionsplice.motion.roles import Roles
from motionsplice.motion.storage.place import At, Place, exists, is_dir, is_named, may_never_end, resolved

GLTF = (".glb", ".gltf", ".vrm", ".vrma")
SCENES = (*GLTF, ".fbx")
WRITERS: Mapping[str, Callable[[Clip, Roles], bytes]] = {
    ".bvh": lambda clip, roles: bvh.dump_bvh(clip),
    ".glb": lambda clip, roles: dump_glb(clip),
    ".gltf": lambda clip, roles: dump_gltf(clip),
    ".vrma": dump_vrma,
}
SUFFIXES = (".amc", ".bvh", *SCENES)
LFS_POINTER = b"version https://git-lfs.github.com/spec/"
Read = Callable[[Place], bytes]
OTHERS = re.compile(  # motion files of other programs
    r"\.(abc|anim|bip|blend|c3d|dae|hkx|htr|imotion|max|m[ab]|md5anim|mot|mvnx|npz|psa|rlmotion|smd|trc|usd[acz]?"
    r"|vmd|vpd)",
    re.IGNORECASE,
)


def clip_files(folder: At) -> list[At]:
    """Returns the motion files in a folder, in order of name, without hidden files, such as macOS' `._walk.bvh`.

    Raises FormatError.
    """
    return [file for file in listing(folder) if file.suffix.lower() in SUFFIXES and file.name[0] != "."]


def other_files(folder: At) -> list[At]:
    """Returns the motion files in a folder that cannot be read, in order of name."""
    return [file for file in listing(folder) if OTHERS.fullmatch(file.suffix) and file.name[0] != "."]


def folders_of_clips(folder: Path) -> list[Path]:
    """Returns the folders in a folder that hold motion files, in order of name."""
    return [one for one in listing(folder) if one.is_dir() and os.access(one, os.R_OK) and clip_files(one)]


def listing(folder: At) -> list[At]:
    """Returns what is in a folder, in order of name. Raises FormatError."""
    try:
        return sorted(folder.iterdir())
    except OSError as error:
        raise FormatError(f"the folder cannot be read: {error.strerror}", file=str(folder)) from None


def clips_in(path: Place) -> dict[str, str | None]:
    """Returns the names of the clips in a file, each with its animation; None for a file that holds one motion.

    A glTF or FBX file with several animations holds a clip `file:animation` for each. Raises FormatError.
    """
    names = _animations(path)
    return {clip_name(path, name if len(names) > 1 else None): name for name in names} or {path.stem: None}


def write_clip(path: Path, clip: Clip, roles: Roles) -> None:
    """Writes a clip as the kind of file that the name ends in, one of WRITERS. Raises RoleError for a .vrma."""
    path.write_bytes(WRITERS[path.suffix.lower()](clip, roles))


def files_behind(path: At) -> tuple[At, ...]:
    """Returns all files that `read_clip` reads for `path`. Raises FormatError if a skeleton file is missing."""
    if path.suffix.lower() == ".amc" and exists(path):
        return path, _skeleton_file(path)
    if path.suffix.lower() == ".gltf" and exists(path):
        return path, *(_beside(path, name) for name in gltf_reader.buffer_files(read_bytes(path)))
    return (path,)


def clip_name(path: Place, animation: str | None) -> str:
    return path.stem if animation is None else f"{path.stem}:{animation}"


def _animations(path: Place) -> list[str]:
    suffix = path.suffix.lower()
    if suffix == ".fbx":
        return fbx_reader.animation_names(read_bytes(path))
    return gltf_reader.animation_names(read_bytes(path)) if suffix in GLTF else []


def parse(
    path: Place, animation: str | None, root: str | None = None, *, still: bool = False, read: Read | None = None
) -> Parsed:
    """Returns what a file says: of several skeletons the one with the joint `root`, else the largest.

    If `still`, a scene without animations gives one frame at rest. read: instead of `read_bytes`. Raises FormatError.
    """
    read = read or read_bytes
    suffix = path.suffix.lower()
    if is_dir(path):
        raise FormatError("this is a folder", mend=f"Give one file in it: {' or '.join(SUFFIXES)}")
    if suffix == ".asf":
        raise FormatError("this is a skeleton without a motion", mend="Give the .amc beside it")
    if suffix not in SUFFIXES:
        raise FormatError(f"unsupported file type {suffix!r}", mend=f"Convert it to {' or '.join(SUFFIXES)}")
    data = read(path)
    if suffix in GLTF:
        scene = gltf_reader.read_scene(data, lambda name: read(_beside(path, name)), animation, still=still)
        return _parsed(scene, root)
    if suffix == ".fbx":
        return _parsed(fbx_reader.read_scene(data, animation, still=still), root)
    if animation is not None:
        raise FormatError(f"a {suffix} file has no animations by name", mend="Leave out --animation")
    if suffix == ".bvh":
        return bvh.parse(data, root)
    asf = _skeleton_file(path)
    try:
        skeleton = asf_amc.parse_skeleton(read(asf))
    except MotionError as error:
        raise error.within(str(asf)) from None
    return asf_amc.parse_motion(data, skeleton)


def _parsed(scene: Scene, root: str | None) -> Parsed:
    nodes, notes = nodes_of(with_own_bind(with_legs_in_place(scene)[0]), root)
    return Parsed(nodes, scene.rate, scene.unit, scene.roles, notes, up="y")


def _beside(path: At, name: str) -> At:
    """Returns a file in the same folder or below it. Raises FormatError for others, which a hostile file may name."""
    file = path.parent / name
    try:
        is_inside = resolved(file).is_relative_to(resolved(path.parent))
    except ValueError:
        raise FormatError(f"it refers to {name!r}, which cannot be a file's name", mend="Export it again") from None
    if not is_inside:
        raise FormatError(f"it refers to {name!r}, outside its folder", mend="Put all its files into one folder")
    return file


def read_bytes(path: Place) -> bytes:
    """Returns the bytes of a file. Raises FormatError if it is missing, unreadable or empty.

    A pipe or a device, which may never end, is refused too.
    """
    try:
        if may_never_end(path):
            raise FormatError("this is a pipe or a device, not a file", file=str(path))
        data = path.read_bytes()
    except IsADirectoryError:
        raise FormatError("this is a folder, not a file", file=str(path), mend="Name the files in it") from None
    except (FileNotFoundError, NotADirectoryError):
        if is_named(path):
            raise FormatError("this link leads nowhere", file=str(path), mend="Mend the link, or remove it") from None
        raise FormatError("no such file", file=str(path), mend="Check the path") from None
    except OSError as error:
        raise FormatError(f"the file cannot be read: {error.strerror}", file=str(path)) from None
    if not data or data.isspace():
        raise FormatError("the file is empty", file=str(path), mend="Export it again")
    if data.startswith(LFS_POINTER):
        problem = "this is a pointer of Git LFS, not the file itself"
        raise FormatError(problem, file=str(path), mend="Run `git lfs pull`")
    return data


def _skeleton_file(path: At) -> At:
    """Returns the ASF file of an AMC file: `16.asf` for `16_15.amc`, or else the only one in the folder."""
    name = path.stem.rpartition("_")[0] or path.stem
    beside = [file for file in listing(path.parent) if file.suffix.lower() == ".asf"]
    named = [file for file in beside if file.stem == name] or beside
    if len(named) == 1:
        return named[0]
    others = f", but {len(beside)} other .asf files" if beside else ""
    raise FormatError(f"found no skeleton {name}.asf in its folder{others}", mend=f"Put {name}.asf beside the motion")
