"""`motionsplice convert`: shows what was understood of a motion file, and writes it in another format."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from motionsplice.commands.outputs import CharacterOption, check_out, open_character, print_sentences, write_motion
from motionsplice.commands.reading_options import Rate, RolesFile, Root, SkipFrames, Unit, Up
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.formats.reading import Reading, read_clip
from motionsplice.motion.hand_joints import fingers_of
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.role_names import PAIRED
from motionsplice.motion.roles import SIDES, read_roles_file
from motionsplice.precompute.job.skeleton import rig_of

console = Console(emoji=False)


def register(app: typer.Typer) -> None:
    app.command("convert", epilog="Example: [bold]motionsplice convert walk.glb walk.bvh --fps 30[/bold]")(
        convert_command
    )


def convert_command(
    motion: Annotated[Path, typer.Argument(help="A motion file (.bvh, .amc, .fbx, .glb, .gltf, .vrm, .vrma).")],
    out: Annotated[Path, typer.Argument(help="The file to write: .bvh, .glb, .gltf or .vrma, in metres.")],
    animation: Annotated[str | None, typer.Option(help="The animation, of a file that has several.")] = None,
    skip_frames: SkipFrames = 0,
    unit: Unit = None,
    up: Up = None,
    rate: Rate = None,
    root: Root = None,
    roles: RolesFile = None,
    skeleton: Annotated[
        Path | None, typer.Option(help="A motion file, character or bank: put the motion on its skeleton.")
    ] = None,
    fps: Annotated[
        float | None, typer.Option(min=1.0, max=1000.0, help="Frames per second to write; default: the file's.")
    ] = None,
    character: CharacterOption = None,
) -> None:
    """Read a motion file, print what was understood, and write it in another format."""
    if skeleton is not None and character is not None:
        raise SettingsError("the character has a skeleton of its own", mend="Leave out --skeleton or --character")
    check_out(out, character, option="OUT")
    receiver = open_character(character)
    given = read_roles_file(roles) if roles else {}
    read = partial(read_clip, skip_frames=skip_frames, unit=unit, up=up, rate=rate, root=root, roles=given)
    reading = read(motion, animation=animation)
    _show(motion, reading)
    clip, own_roles, notes = reading.clip, reading.roles, tuple[str, ...]()
    if skeleton is not None:
        rig = rig_of(skeleton, given)
        fitted = onto_rig(clip, own_roles, rig)
        clip, own_roles, notes = fitted.clip, rig.roles, fitted.notes
    if fps is not None:
        clip = at_rate(clip, fps)
    notes += write_motion(out, clip, own_roles, receiver)
    onto = f", on the skeleton of {skeleton or character}" if skeleton or character else ""
    console.print(f"{out}: {_length(clip)}{onto}", highlight=False, soft_wrap=True, markup=False)
    print_sentences(console, "dim", notes)


def at_rate(clip: Clip, rate: float) -> Clip:
    """Returns the motion at another rate: positions linearly, rotations by slerp.

    The last frame is the one nearest to the clip's end; if it lies behind the end, it is the clip's last frame. So the
    length changes by at most half a frame.
    """
    count = round(clip.duration * rate) + 1
    positions, rotations = clip.sampled(np.arange(count) * (clip.rate / rate))
    return replace(clip, rate=rate, root_positions=positions, rotations=rotations)


def _show(motion: Path, reading: Reading) -> None:
    """Prints what was understood of a file."""
    clip, roles = reading.clip, reading.roles
    names = clip.skeleton.names
    rows = {
        "motion": f"{clip.name!r}, {_length(clip)}",
        "skeleton": f"{clip.skeleton.joint_count} joints, {names[0]!r} is the root",
        "unit": f"{reading.unit:g} m; the legs are {roles.leg_length(clip.skeleton):.2f} m long",
        "trunk": _listed(names, {"pelvis": roles.pelvis, "spine": roles.spine, "neck": roles.neck, "head": roles.head}),
    }
    for side in SIDES:
        limbs = _listed(names, {part: getattr(roles, f"{side}_{part}") for part in PAIRED})
        rows[side] = f"{limbs}, {len(fingers_of(clip.skeleton, roles, side)) or 'no'} finger joints"
    table = Table.grid(padding=(0, 2))
    table.add_column(style="dim")
    table.add_column(overflow="fold")
    for label, text in rows.items():
        table.add_row(label, escape(text))
    for label, style, sentences in (("note", "dim", reading.notes), ("warning", "yellow", reading.warnings)):
        for sentence in sentences:
            table.add_row(label, f"[{style}]{escape(sentence)}[/{style}]")
    console.print(f"{motion}:", highlight=False, soft_wrap=True, markup=False)
    console.print(table, highlight=False)


def _length(clip: Clip) -> str:
    return f"{clip.frame_count} frames at {clip.rate:g} per second, {clip.duration:.2f} s"


def _listed(names: tuple[str, ...], joints: dict[str, int | tuple[int, ...]]) -> str:
    """Returns the joints of roles as text; -1 is a role that the rig does not have."""
    text = []
    for role, joint in joints.items():
        found = [names[one] for one in ([joint] if isinstance(joint, int) else joint) if one >= 0]
        text.append(f"{role} {' + '.join(found) or '(none)'}")
    return ", ".join(text)
