"""`motionsplice splice` and `render`: motions from a bank, and pictures of motions.

The evaluator and the pictures are imported when they are needed, so that a misspelt clip name is reported at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from motionsplice.commands.outputs import (
    CharacterOption,
    OutOption,
    check_out,
    check_suffix,
    open_character,
    print_sentences,
    write_motion,
)
from motionsplice.commands.reading_options import Rate, RolesFile, Root, SkipFrames, Unit, Up, print_remarks
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.roles import Side

if TYPE_CHECKING:
    from motionsplice.motion.clip import Clip
    from motionsplice.precompute import splice as whole_clip
    from motionsplice.runtime import requests
    from motionsplice.runtime.bank import Bank
    from motionsplice.runtime.evaluator import Evaluator
    from motionsplice.runtime.expectation import Expectation
    from motionsplice.runtime.splice import Splice

ONE_STRIDE = 1.5  # cycles: an action with fewer shows no second stride
ODD_LEGS = 0.08  # metres between legs: those of walks are within 0.03
ODD_SPEED = 1.25  # of the captured speed, faster or slower

console = Console(emoji=False)


class Method(StrEnum):
    """How the upper body is put on the lower body."""

    SPLICE = "splice"
    NAIVE = "naive"
    EXACT = "exact"
    NONE = "none"


class Posture(StrEnum):
    """How the action's posture is kept."""

    RELATIVE = "relative"
    ABSOLUTE = "absolute"
    RUNNING = "running"
    OFF = "off"


RUN_TIME_METHODS: Mapping[Method, requests.Method] = {
    Method.SPLICE: "splice",
    Method.NAIVE: "naive",
    Method.NONE: "none",
}
WHOLE_CLIP_POSTURES: Mapping[Posture, whole_clip.Posture] = {
    Posture.RELATIVE: "relative",
    Posture.ABSOLUTE: "absolute",
    Posture.OFF: "off",
}


def register(app: typer.Typer) -> None:
    app.command(
        "splice",
        epilog="Example: [bold]motionsplice splice bank --locomotion curve --action carry_box --out box.bvh[/bold]",
    )(splice_command)
    app.command("render", epilog="Example: [bold]motionsplice render walk.bvh box.bvh --out sheet.png[/bold]")(
        render_command
    )


def splice_command(
    bank: Annotated[Path, typer.Argument(help="A bank, as `precompute` wrote it.")],
    locomotion: Annotated[str, typer.Option(help="The clip that gives the root and the lower body.")],
    out: OutOption,
    action: Annotated[
        str | None, typer.Option(help="The clip that gives the upper body; without it, the locomotion alone.")
    ] = None,
    method: Annotated[
        Method,
        typer.Option(
            help="splice: aligned by the bank; naive: rotations replaced; exact: the papers' whole-clip splice; "
            "none: the locomotion alone."
        ),
    ] = Method.SPLICE,
    posture: Annotated[
        Posture,
        typer.Option(
            help="relative: add what the action does beyond its gait or its stance; absolute: keep the action's "
            "mean posture, as in the papers; running: like absolute, with a running mean; off: keep the locomotion's."
        ),
    ] = Posture.RELATIVE,
    start: Annotated[
        float, typer.Option(help="Earliest second of the action; it begins at the next frame in step.")
    ] = 0.0,
    hands: Annotated[str | None, typer.Option(help="A hands clip, aligned to the action, to lay on it.")] = None,
    seconds: Annotated[
        float | None,
        typer.Option(help="How long the result is: the locomotion repeats its loop. Default: the locomotion's length."),
    ] = None,
    character: CharacterOption = None,
) -> None:
    """Splice an action's upper body onto a locomotion, and write the motion as BVH, glTF or VRM animation."""
    check_out(out, character)
    from motionsplice.runtime.bank import Bank

    opened = Bank.open(bank)
    whole = opened.clip(locomotion)  # raises UnknownClipError before anything slow is imported
    if action is not None:
        opened.clip(action)
    receiver = open_character(character)
    clip = spliced(opened, locomotion, action, method, posture, start, hands, seconds)
    notes = write_motion(out, clip, opened.roles, receiver)
    part = f" of {whole.duration:.2f} s" if clip.frame_count < whole.frame_count else ""
    console.print(f"{out}: {clip.frame_count} frames at {clip.rate:g} per second, {clip.duration:.2f} s{part}")
    print_sentences(console, "dim", notes)
    from motionsplice.commands.length import cut_short
    from motionsplice.runtime.evaluator import Evaluator

    evaluator, splice = Evaluator(opened), asked(locomotion, action, method, posture, start, hands)
    if seconds is None and (sentence := cut_short(evaluator, splice)):
        print_sentences(console, "yellow", [sentence])
    if method is Method.SPLICE:
        print_expectation(evaluator, splice)


def print_expectation(evaluator: Evaluator, splice: Splice) -> None:
    """Prints how far a splice can be trusted, and a warning if plain replacement may be as good.

    Of an action without a gait nothing is known but the job's warnings, which are repeated.
    """
    from motionsplice.runtime.expectation import expectation

    found, bank = expectation(evaluator, splice), evaluator.bank
    if found is None:
        warnings = () if splice.action is None else bank.clip(splice.action).warnings
        print_sentences(console, "yellow", (f"{splice.action}: {warning}" for warning in warnings))
        return
    repeats = f", the action repeats within {100 * found.repetition:.1f} cm" if found.repetition > 0.0 else ""
    console.print(
        f"expected: {100 * found.error:.1f} cm off, plain replacement {100 * found.replaced:.1f} cm; "
        f"legs within {100 * found.legs:.1f} cm{repeats}; "
        f"it plays at {found.slowest:.2f} to {found.fastest:.2f} times its captured speed",
        style="dim",
        soft_wrap=True,
    )
    if splice.action is not None and is_odd_stride(bank.clip(splice.action).cycles, found):
        sentence = f"{splice.action!r} takes one stride that does not fit {splice.locomotion!r}"
        mend = "if it is a lunge or a step, not a gait, name an idle as its `neutral` in clips.toml"
        print_sentences(console, "yellow", [f"{sentence}: {mend}"])
    if found.gains_little:
        sentence = f"{splice.action!r} hardly follows the stride, so plain replacement may be as good"
        print_sentences(console, "yellow", [f"{sentence}: in a game, try `own_clock`"])


def is_odd_stride(cycles: float, found: Expectation) -> bool:
    """Returns whether an action of one stride plays far from its captured speed, or with legs far from it.

    Its steps are then hardly those of a gait: a lunge looks like a stride to the offline job.
    """
    is_far = found.legs > ODD_LEGS or found.fastest < 1.0 / ODD_SPEED or found.slowest > ODD_SPEED
    return cycles < ONE_STRIDE and is_far


def asked(
    locomotion: str, action: str | None, method: Method, posture: Posture, start: float, hands: str | None
) -> Splice:
    """Returns what the evaluator is asked for."""
    from motionsplice.runtime.splice import Splice

    form = RUN_TIME_METHODS.get(method, "none")
    return Splice(locomotion, action, start=start, method=form, posture=posture.value, hands=hands)


def spliced(
    bank: Bank,
    locomotion: str,
    action: str | None,
    method: Method,
    posture: Posture,
    start: float,
    hands: str | None = None,
    seconds: float | None = None,
) -> Clip:
    """Returns a splice by any method: `seconds` of it, or as long as the locomotion. Raises MotionError."""
    if method is not Method.EXACT or action is None:
        splice = asked(locomotion, action, method, posture, start, hands)
        if seconds is not None:
            from motionsplice.commands.length import lasting

            return lasting(bank, splice, seconds)
        from motionsplice.runtime.evaluator import Evaluator

        return Evaluator(bank).clip(splice)
    if seconds is not None:
        mend = "Leave out --seconds, or use --method splice"
        raise SettingsError("the exact splice is as long as its locomotion", mend=mend)
    if hands is not None:
        raise SettingsError("the exact splice cannot lay hands", mend="Leave out --hands, or use --method splice")
    if stretches := bank.clip(action).stretches:
        problem = f"the exact splice cannot play {action!r}, which stands and walks by turns"
        raise SettingsError(problem, mend=f"Use --method splice, or one of {', '.join(stretches)}")
    standing, clip_l, clip_u = bank.standing(action), bank.motion(locomotion), bank.motion(action)
    if standing is not None and posture is Posture.RELATIVE:
        from motionsplice.precompute.splice import splice_standing

        return splice_standing(clip_l, clip_u, bank.roles, standing, start=start)
    if start != 0.0:
        raise SettingsError("the exact splice chooses its own start", mend="Leave out --start")
    if posture not in WHOLE_CLIP_POSTURES:
        known = ", ".join(WHOLE_CLIP_POSTURES)
        raise SettingsError(f"the exact splice has no posture {posture.value!r}", mend=f"Choose --posture {known}")
    from motionsplice.precompute.splice import splice_exact

    offsets = bank.torso(locomotion).offsets, bank.torso(action).offsets
    return splice_exact(clip_l, clip_u, bank.roles, posture=WHOLE_CLIP_POSTURES[posture], torso_offsets=offsets).clip


def render_command(
    motions: Annotated[list[Path], typer.Argument(help="Motion files (.bvh, .amc, .fbx, .glb, ...), one row each.")],
    out: Annotated[Path, typer.Option(help="A .png contact sheet, or a .gif that plays the motions side by side.")],
    ghost: Annotated[Path | None, typer.Option(help="A motion of the same rig, drawn in grey behind each row.")] = None,
    columns: Annotated[int, typer.Option(min=1, max=60, help="Moments in each row of a contact sheet.")] = 10,
    start: Annotated[float, typer.Option(min=0.0, help="Second at which drawing starts.")] = 0.0,
    end: Annotated[float | None, typer.Option(min=0.0, help="Second at which drawing ends; default: the last.")] = None,
    view: Annotated[str, typer.Option(help="side, front or three-quarter.")] = "three-quarter",
    hand: Annotated[Side | None, typer.Option(help="Draw only this hand, as a close-up.")] = None,
    clip: Annotated[str | None, typer.Option("--animation", help="The animation, of files that have several.")] = None,
    skip_frames: SkipFrames = 0,
    unit: Unit = None,
    up: Up = None,
    rate: Rate = None,
    root: Root = None,
    roles: RolesFile = None,
) -> None:
    """Draw motions as stick figures, or one hand of each, to judge them by eye."""
    kind = check_suffix(out, ".png", ".gif")
    from motionsplice.motion.formats.reading import read_clip
    from motionsplice.motion.roles import read_roles_file
    from motionsplice.pictures.sheets import animation, contact_sheet

    given = read_roles_file(roles) if roles else {}
    read = partial(read_clip, skip_frames=skip_frames, unit=unit, up=up, rate=rate, root=root, roles=given)
    readings = [read(file, animation=clip) for file in motions]
    rows = [(reading.clip.name, reading.clip, reading.roles) for reading in readings]
    behind = read(ghost).clip if ghost else None
    if kind == ".png":
        contact_sheet(rows, columns=columns, start=start, end=end, view=view, ghost=behind, hand=hand).save(out)
    else:
        out.write_bytes(animation(rows, start=start, end=end, view=view, ghost=behind, hand=hand))
    console.print(f"{out}")
    for reading in readings:
        print_remarks(console, reading)
