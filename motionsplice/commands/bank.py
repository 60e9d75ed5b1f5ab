"""`motionsplice precompute` and `motionsplice inspect`: building and listing a bank.

The offline job is imported when it is needed, so that `inspect` starts fast.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

from motionsplice.commands.progress_file import ProgressFile
from motionsplice.commands.reading_options import Rate, RolesFile, Root, SkipFrames, Unit, Up
from motionsplice.motion.clip_settings import DEFAULT_SETTINGS, ClipSettings
from motionsplice.motion.errors import MotionError
from motionsplice.runtime.bank import Bank

if TYPE_CHECKING:
    from motionsplice.precompute.hands.settings import HandsOnBody
    from motionsplice.precompute.job.outcome import Outcome

AUTOMATIC = "auto"

console = Console(emoji=False)


def register(app: typer.Typer) -> None:
    app.command("precompute", epilog="Example: [bold]motionsplice precompute clips/ --out bank --baseline walk[/bold]")(
        precompute_command
    )
    app.command("inspect", epilog="Example: [bold]motionsplice inspect bank[/bold]")(inspect_command)


def precompute_command(
    clips: Annotated[list[Path], typer.Argument(help="Motion files (.bvh, .fbx, .glb, ...), or folders of them.")],
    out: Annotated[Path, typer.Option(help="The bank to write, a folder.")],
    baseline: Annotated[
        str, typer.Option(help="The clip to whose stride all clips are aligned; auto: the most typical stride.")
    ] = AUTOMATIC,
    jobs: Annotated[int | None, typer.Option(min=1, help="Number of processes; default: one per core.")] = None,
    roles: RolesFile = None,
    hands: Annotated[
        list[str] | None, typer.Option(help="BODY:HANDS: lay the hands of clip HANDS on clip BODY.")
    ] = None,
    skeleton: Annotated[
        Path | None,
        typer.Option(help="A motion file, or a bank, whose rig the bank gets; default: the baseline's rig."),
    ] = None,
    retarget: Annotated[
        bool, typer.Option("--retarget/--no-retarget", help="Move clips of other rigs over by roles, or refuse them.")
    ] = True,
    skip_frames: SkipFrames = 0,
    unit: Unit = None,
    up: Up = None,
    rate: Rate = None,
    root: Root = None,
    progress: Annotated[Path | None, typer.Option(help="File to write progress to, as JSON.")] = None,
) -> None:
    """Align clips to a baseline locomotion, and write a bank.

    A clips.toml beside the clips may set the kind ("locomotion" or "action"), neutral, tags, skip_frames, unit, up,
    rate, root and roles file of each clip. A hands.toml lists which hands are laid on which bodies, and how. If a clip fails, its
    reason is printed, the others finish, and the exit status is 1.
    """
    from motionsplice.precompute.hands.settings import HandsOnBody

    file = ProgressFile(progress) if progress is not None else None
    try:
        outcome = run(
            clips,
            out,
            baseline=None if baseline == AUTOMATIC else baseline,
            jobs=jobs,
            settings=ClipSettings(skip_frames=skip_frames, unit=unit, up=up, rate=rate, root=root),
            roles_file=roles,
            hands=[HandsOnBody.parse(one) for one in hands or ()],
            skeleton=skeleton,
            retarget=retarget,
            file=file,
        )
    except MotionError as problem:
        if file is not None:
            file.fail(str(problem))
        raise
    if file is not None:
        file.finish(outcome)
    print_work(outcome, out)
    print_left_out(clips)
    if not outcome.unchanged:
        show_bank(Bank.open(out))
    for name, error in outcome.failed.items():
        console.print(f"[red]{escape(name)} failed:[/red] {escape(str(error))}", highlight=False, soft_wrap=True)
    if outcome.failed:
        raise typer.Exit(1)


def run(
    clips: list[Path],
    out: Path,
    *,
    baseline: str | None = None,
    jobs: int | None = None,
    settings: ClipSettings = DEFAULT_SETTINGS,
    roles_file: Path | None = None,
    hands: Sequence[HandsOnBody] = (),
    skeleton: Path | None = None,
    retarget: bool = True,
    file: ProgressFile | None = None,
) -> Outcome:
    """Runs the offline job behind a progress bar. Raises MotionError."""
    from motionsplice.motion.roles import read_roles_file
    from motionsplice.precompute.job.job import build_bank

    columns = (TextColumn("{task.description:>9}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as bar:
        tasks: dict[str, TaskID] = {}

        def show(stage: str, done: int, total: int) -> None:
            if stage not in tasks:  # a stage without work has no bar
                tasks[stage] = bar.add_task(stage)
            bar.update(tasks[stage], completed=done, total=total)
            if file is not None:
                file.show(stage, done, total)

        return build_bank(
            clips,
            out,
            baseline=baseline,
            jobs=jobs or os.cpu_count() or 1,
            settings=settings,
            roles=read_roles_file(roles_file) if roles_file else {},
            hands=hands,
            skeleton=skeleton,
            retarget=retarget,
            progress=show,
        )


def print_work(outcome: Outcome, out: Path) -> None:
    """Prints how many clips were processed, and how many were reused or failed."""
    count = f"{len(outcome.clips)} clip{'s' * (len(outcome.clips) != 1)}"
    if outcome.unchanged:
        line = f"{out}: nothing to do, none of its {count} changed"
    else:
        line = f"{count}, {outcome.reused} reused"
    failed = f", {len(outcome.failed)} failed" if outcome.failed else ""
    console.print(line + failed, highlight=False, soft_wrap=True)


def print_left_out(clips: list[Path]) -> None:
    """Prints which motion files in the folders cannot be read."""
    from motionsplice.motion.formats.files import other_files
    from motionsplice.motion.formats.fold import listed

    others = [file.name for path in clips if path.is_dir() for file in other_files(path)]
    if others:
        line = f"left out, cannot be read: {listed(others)}. Export them as BVH or GLB"
        console.print(f"[yellow]{escape(line)}[/yellow]", highlight=False, soft_wrap=True)


def inspect_command(bank: Annotated[Path, typer.Argument(help="A bank, as `precompute` wrote it.")]) -> None:
    """Show the clips of a bank, and how well each is aligned to the baseline."""
    show_bank(Bank.open(bank))


def show_bank(bank: Bank) -> None:
    """Prints a bank's clips and hands as tables, and the warnings and notes of the job."""
    stride = bank.baseline.end - bank.baseline.start
    console.print(
        f"{bank.path}: {len(bank.clips)} clips, {bank.skeleton.joint_count} joints, baseline {bank.baseline.clip!r} "
        f"(a stride of {stride:.2f} s from {bank.baseline.start:.2f} s)",
        highlight=False,
        soft_wrap=True,
    )
    table = Table(
        caption="mean, worst: distance of root and knees from the baseline's at the same phase, cm; "
        "shoulders: motion of an action's shoulders beyond its neutral's gait, degrees"
    )
    for column in ("clip", "neutral"):
        table.add_column(column, overflow="fold")
    for column in ("seconds", "rate", "cycles", "mean", "worst", "shoulders"):
        table.add_column(column, justify="right", no_wrap=True)
    for clip in bank.clips:
        mean = f"{100 * clip.mean_mismatch:.1f}"
        table.add_row(
            " ".join((escape(clip.name), *(f"[cyan]#{escape(tag)}[/cyan]" for tag in clip.tags))),
            escape(bank.neutral(clip.name)) if clip.kind == "action" else "",
            f"{clip.duration:.2f}",
            f"{clip.rate:.5g}",
            f"{clip.cycles:.2f}",
            f"[yellow]{mean}[/yellow]" if clip.warnings else mean,
            f"{100 * clip.worst_mismatch:.1f}",
            f"{np.degrees(clip.shoulder_motion):.1f}" if clip.kind == "action" else "",
        )
    console.print(table)
    if bank.hands:
        console.print(hands_table(bank))
    warnings = [(clip.name, clip.warnings) for clip in bank.clips] + [(one.name, one.warnings) for one in bank.hands]
    for style, messages in (("yellow", warnings), ("dim", [(clip.name, clip.notes) for clip in bank.clips])):
        names: dict[str, list[str]] = {}
        for name, sentences in messages:
            for sentence in sentences:
                names.setdefault(sentence, []).append(name)
        for sentence, clips in names.items():
            console.print(
                f"[{style}]{escape(', '.join(clips))}: {escape(sentence)}[/{style}]", highlight=False, soft_wrap=True
            )


def hands_table(bank: Bank) -> Table:
    """Returns a table of the hands on each clip, and of how far their time runs from the body's."""
    table = Table(
        caption="mismatch: mean phase cost of aligned frames over that of all frames in the band, 0 for identical "
        "gestures and about 1 for unrelated ones; ahead: seconds by which the hands run ahead of the body, least and "
        "most"
    )
    for column in ("hands", "on", "hand", "wrist", "pairs"):
        table.add_column(column, overflow="fold")
    for column in ("mismatch", "ahead"):
        table.add_column(column, justify="right", no_wrap=True)
    for one in bank.hands:
        frames, rate = bank.hand_frames(one.name, one.body), bank.clip(one.body).rate
        sides = {"left": [0], "right": [1]}.get(one.hand, [0, 1])
        ahead = frames[:, sides] / one.rate - np.arange(len(frames))[:, None] / rate
        table.add_row(
            escape(one.name),
            escape(one.body),
            one.hand,
            "yes" if one.wrist else "",
            " ".join(one.pairs),
            f"[yellow]{one.mismatch:.2f}[/yellow]" if one.warnings else f"{one.mismatch:.2f}",
            f"{ahead.min():.2f} to {ahead.max():.2f}",
        )
    return table
