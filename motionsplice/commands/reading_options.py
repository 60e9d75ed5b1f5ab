"""Commands that read motion files: their options, as `read_clip` takes them, and what they print of a reading."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from motionsplice.commands.outputs import print_sentences

if TYPE_CHECKING:
    from motionsplice.motion.formats.reading import Reading

SkipFrames = Annotated[int, typer.Option(min=0, help="Leading frames that are not motion (a T-pose).")]
Unit = Annotated[str | None, typer.Option(help="m, cm, mm, in, ft, cmu or metres per unit; default: guessed.")]
Up = Annotated[str | None, typer.Option(help="The axis that is up in the file: x, y, z, -x, -y or -z; default: found.")]
Rate = Annotated[float | None, typer.Option(help="Frames per second, if the file states it wrongly.")]
Root = Annotated[str | None, typer.Option(help="Root joint of the body to read, of a file with several.")]
RolesFile = Annotated[Path | None, typer.Option(help="TOML file that names joints by role, for all clips read.")]


def print_remarks(console: Console, reading: Reading) -> None:
    """Prints the warnings and notes of a reading, each after the clip's name."""
    for style, sentences in (("yellow", reading.warnings), ("dim", reading.notes)):
        print_sentences(console, style, [f"{reading.clip.name}: {sentence}" for sentence in sentences])
