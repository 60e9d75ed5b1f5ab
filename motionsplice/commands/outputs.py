"""The files that commands write: their suffixes, and motions, by themselves or in a character's file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from motionsplice.motion.errors import SettingsError

if TYPE_CHECKING:
    from motionsplice.motion.clip import Clip
    from motionsplice.motion.formats.character import Character
    from motionsplice.motion.roles import Roles
    from motionsplice.motion.skeleton import Skeleton

WRITTEN = (".bvh", ".glb", ".gltf", ".vrma")  # the keys of `formats.files.WRITERS`, whose import takes a second
OutOption = Annotated[Path, typer.Option(help="The file to write: .bvh, .glb, .gltf or .vrma, in metres.")]
CharacterOption = Annotated[
    Path | None,
    typer.Option(
        help="A .glb or .vrm with your character: write a copy of it with the motion, retargeted to its bones."
    ),
]


def check_suffix(file: Path, *suffixes: str, option: str = "--out") -> str:
    """Returns a file's suffix in lower case. Raises SettingsError if it is none of `suffixes`."""
    suffix = file.suffix.lower()
    if suffix not in suffixes:
        known = " or ".join(suffixes)
        raise SettingsError(f"only {known} can be written", file=f"{option} {file}", mend=f"End the name in {known}")
    return suffix


def check_out(out: Path, character: Path | None, *, option: str = "--out") -> None:
    """Raises SettingsError unless a motion can be written to the file, or into a copy of the character's file."""
    if character is None:
        check_suffix(out, *WRITTEN, option=option)
    elif character.suffix.lower() == ".vrm":
        check_suffix(out, ".glb", ".vrm", option=option)
    else:
        check_suffix(out, ".glb", option=option)


def open_character(file: Path | None) -> Character | None:
    """Reads the file of `--character`, if there is one. Raises MotionError."""
    if file is None:
        return None
    from motionsplice.motion.formats.character import read_character

    return read_character(file)


def write_motion(out: Path, clip: Clip, roles: Roles, character: Character | None) -> None:
    """Writes a motion as the kind of file that the name ends in, or into a copy of a character's file.

    Raises SkeletonError if the character's skeleton does not fit, RoleError for a .vrma of a rig without a head.
    """
    if character is None:
        from motionsplice.motion.formats.files import write_clip

        write_clip(out, clip, roles)
    else:
        out.write_bytes(character.animated(retargeted(clip, roles, character.skeleton, character.roles)))


def retargeted(clip: Clip, roles: Roles, skeleton: Skeleton, skeleton_roles: Roles) -> Clip:
    """Returns a clip on another skeleton. Raises SkeletonError."""
    from motionsplice.precompute.body.common_skeleton import onto_skeleton

    return onto_skeleton(clip, roles, skeleton, skeleton_roles)
