"""`motionsplice hands`: lays separately captured hands on the body of another clip."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path
from typing import Annotated, get_args

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from motionsplice.commands.outputs import (
    CharacterOption,
    OutOption,
    check_out,
    check_suffix,
    open_character,
    print_sentences,
    write_motion,
)
from motionsplice.commands.reading_options import Rate, RolesFile, Root, SkipFrames, Unit, Up
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.formats.reading import Reading, read_clip
from motionsplice.motion.roles import read_roles_file
from motionsplice.pictures.hand_charts import draw_alignment
from motionsplice.precompute.hands.align import BANDS
from motionsplice.precompute.hands.banded_warp import FramePair
from motionsplice.precompute.hands.phases import PhaseKind, count_phases, phases
from motionsplice.precompute.hands.settings import HandChoice, HandSettings, Turn
from motionsplice.precompute.hands.splice import HandSplice, splice_hands

KINDS: tuple[PhaseKind, ...] = get_args(PhaseKind)

console = Console(emoji=False)


def register(app: typer.Typer) -> None:
    app.command(
        "hands",
        epilog="Example: [bold]motionsplice hands walk.bvh signs.bvh --out walk+signs.bvh --pair 300:288~5[/bold]",
    )(hands_command)


def hands_command(
    body: Annotated[Path, typer.Argument(help="The motion that gives the body (.bvh, .amc, .fbx, .glb, ...).")],
    hands: Annotated[
        Path, typer.Argument(help="The motion that gives the fingers: the same gestures, captured separately.")
    ],
    out: OutOption,
    pair: Annotated[
        list[str] | None,
        typer.Option(help="BODY:HANDS, two frames to align; BODY:HANDS~N allows N frames of the hands either way."),
    ] = None,
    band: Annotated[
        str, typer.Option(help="Half width of each pass's band, as a share of the body's frames.")
    ] = f"{BANDS[0]},{BANDS[1]}",
    hand: Annotated[
        HandChoice, typer.Option(help="both: align the hands together; each: align each separately.")
    ] = "both",
    turn: Annotated[
        Turn, typer.Option(help="window: rotate the hands to fit a window of frames; trunk: to fit the trunk.")
    ] = "window",
    wrist: Annotated[bool, typer.Option("--wrist", help="Also take the wrists and the twist of the forearms.")] = False,
    picture: Annotated[Path | None, typer.Option(help="A .png to write: costs, bands, paths and curves.")] = None,
    skip_frames: SkipFrames = 0,
    unit: Unit = None,
    up: Up = None,
    rate: Rate = None,
    root: Root = None,
    roles: RolesFile = None,
    character: CharacterOption = None,
) -> None:
    """Align hands to a body that was captured separately, and write the body with their fingers.

    The first pass aligns the phases of gestures, the second the frames within them. Pairs of frames constrain both.
    Frames count from 0.
    """
    check_out(out, character)
    if picture is not None:
        check_suffix(picture, ".png", option="--picture")
    settings = HandSettings(hand, wrist, turn, _bands(band), tuple(FramePair.parse(one) for one in pair or ()))
    given = read_roles_file(roles) if roles else {}
    receiver = open_character(character)
    read = partial(read_clip, skip_frames=skip_frames, unit=unit, up=up, rate=rate, root=root, roles=given)
    ours, theirs = read(body), read(hands)
    begin = time.perf_counter()
    spliced = splice_hands(ours.clip, ours.roles, theirs.clip, theirs.roles, settings)
    seconds = time.perf_counter() - begin
    for clip, warnings in ((ours.clip, ours.warnings), (theirs.clip, (*theirs.warnings, *spliced.warnings))):
        for sentence in warnings:
            console.print(f"[yellow]{escape(f'{clip.name}: {sentence}')}[/yellow]", soft_wrap=True)
    console.print(phase_table(spliced, ours, theirs))
    for line in _alignment_lines(spliced, theirs, settings):
        console.print(f"  {line}", highlight=False)
    notes = write_motion(out, spliced.clip, spliced.roles, receiver)
    count = f"{spliced.clip.frame_count} frames at {spliced.clip.rate:g} per second"
    console.print(f"{out}: {count}, aligned and merged in {seconds:.2f} s", highlight=False, soft_wrap=True)
    print_sentences(console, "dim", notes)
    if picture is not None:
        draw_alignment(spliced, settings, theirs.clip.rate, picture)
        console.print(f"{picture}", soft_wrap=True)


def phase_table(spliced: HandSplice, body: Reading, hands: Reading) -> Table:
    """Returns a table of the number of phases of each kind in either performer's hands (the paper's table 2)."""
    table = Table(caption="phases of gestures, counted in both motions")
    table.add_column("hand", no_wrap=True)
    table.add_column("of", overflow="fold", min_width=8)
    for column in ("seconds", *(f"{kind}s" for kind in KINDS)):
        table.add_column(column, justify="right", no_wrap=True)
    rate = spliced.clip.rate
    for aligned in spliced.aligned:
        for side in aligned.body:
            for clip, moves in ((body.clip, aligned.body[side]), (hands.clip, aligned.hands[side])):
                counts = count_phases(phases(moves, rate))
                numbers = (str(counts.get(kind, 0)) for kind in KINDS)
                table.add_row(side, escape(clip.name), f"{clip.duration:.2f}", *numbers)
            table.add_section()
    return table


def _alignment_lines(spliced: HandSplice, hands: Reading, settings: HandSettings) -> list[str]:
    """Returns a line for each alignment, and one for each pair."""
    lines = []
    rate, own = spliced.clip.rate, hands.clip.rate
    for aligned in spliced.aligned:
        frames = spliced.frames[next(iter(aligned.body))]
        ahead = frames / own - np.arange(len(frames)) / rate
        slow, fast = np.percentile(np.diff(frames) * rate / own, [5.0, 95.0]) if len(frames) > 1 else (1.0, 1.0)
        lines.append(
            f"{' and '.join(aligned.body)}: hands run {ahead.min():+.2f} to {ahead.max():+.2f} s ahead of the body, "
            f"at {slow:.1f} to {fast:.1f} times their own pace; mismatch {aligned.alignment.mismatch:.2f}"
        )
        lines += [f"pair {one}: frame {frames[one.body]:.1f} of the hands" for one in settings.pairs]
    return lines


def _bands(text: str) -> tuple[float, float]:
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        raise SettingsError(f"--band: expected two numbers, found {text!r}", mend="Example: 0.3,0.1") from None
    return first, second
