"""The files that commands write: their suffixes, and motions, by themselves or in a character's file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape

from motionsplice.motion.errors import SettingsError

if TYPE_CHECKING:
    from motionsplice.motion.clip import Clip
    from motionsplice.motion.formats.character import Character
    from motionsplice.motion.roles import Roles

WRITTEN = (".bvh", ".glb", ".gltf", ".vrma")  # the keys of `formats.files.WRITERS`, whose import takes a second
OutOption = Annotated[Path, typer.Option(help="The file to write: .bvh, .glb, .gltf or .vrma, in metres.")]
CharacterOption = Annotated[
    Path | None,
    typer.Option(
        help="A .glb or .vrm with your character: write a copy of it with the motion, retargeted to its bones."
    ),
]


def check_suffix(file: Path, *suffixes: str, option: str = "--out", what: str = "") -> str:
    """Returns a file's suffix in lower case. Raises SettingsError if it is none of `suffixes`.

    what: ends the sentence that only these can be written.
    """
    suffix = file.suffix.lower()
    if suffix not in suffixes:
        known = " or ".join(suffixes)
        raise SettingsError(
            f"only {known} can be written{what}", file=f"{option} {file}", mend=f"End the name in {known}"
        )
    return suffix


def check_out(out: Path, character: Path | None, *, option: str = "--out") -> None:
    """Raises SettingsError unless a motion can be written to the file, or into a copy of the character's file."""
    if character is None:
        check_suffix(out, *WRITTEN, option=option)
    elif character.suffix.lower() not in (".glb", ".vrm"):
        mend = "Export the character as .glb or .vrm; Blender makes a .glb of an .fbx"
        raise SettingsError("this is not a GLB file", file=f"--character {character}", mend=mend)
    else:
        suffixes = (".glb", ".vrm") if character.suffix.lower() == ".vrm" else (".glb",)
        check_suffix(out, *suffixes, option=option, what=f" with the character {character}")


def open_character(file: Path | None) -> Character | None:
    """Reads the file of `--character`, if there is one. Raises MotionError."""
    if file is None:
        return None
    from motionsplice.motion.formats.character import read_character

    return read_character(file)


def write_motion(out: Path, clip: Clip, roles: Roles, character: Character | None) -> tuple[str, ...]:
    """Writes a motion as the kind of file that the name ends in, or into a copy of a character's file.

    Returns notes for the user. Raises SkeletonError if the motion does not fit the character, RoleError for a .vrma of
    a rig without a head.
    """
    if character is None:
        from motionsplice.motion.formats.files import write_clip

        write_clip(out, clip, roles)
        return ()
    from motionsplice.motion.retarget.onto_rig import onto_rig
    from motionsplice.motion.retarget.rig import Rig

    fitted = onto_rig(clip, roles, Rig(character.skeleton, character.roles))
    out.write_bytes(character.animated(fitted.clip))
    return fitted.notes


def print_sentences(console: Console, style: str, sentences: Iterable[str]) -> None:
    """Prints notes or warnings, one a line."""
    for sentence in sentences:
        console.print(f"[{style}]{escape(sentence)}[/{style}]", highlight=False, soft_wrap=True)
