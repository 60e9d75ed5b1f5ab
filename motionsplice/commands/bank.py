"""`motionsplice precompute`, `install` and `inspect`: building, copying and listing a bank.

The offline job is imported when it is needed, so that `inspect` starts fast.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from motionsplice.commands.bank_report import notes_of, print_grouped, reasons_of, show_tables, uneven_clips
from motionsplice.commands.outputs import print_sentences
from motionsplice.commands.progress_file import ProgressFile
from motionsplice.commands.reading_options import Rate, RolesFile, Root, SkipFrames, Unit, Up
from motionsplice.motion.clip_settings import DEFAULT_SETTINGS, ClipSettings
from motionsplice.motion.errors import MotionError
from motionsplice.motion.storage.place import place_of
from motionsplice.motion.storage.remote import Remote
from motionsplice.runtime.bank import Bank

if TYPE_CHECKING:
    from motionsplice.precompute.hands.settings import HandsOnBody
    from motionsplice.precompute.job.outcome import Outcome

AUTOMATIC = "auto"

console = Console(emoji=False)
messages = Console(stderr=True, emoji=False)  # progress and failures: standard output has the report


def register(app: typer.Typer) -> None:
    app.command("precompute", epilog="Example: [bold]motionsplice precompute clips/ --out bank --baseline walk[/bold]")(
        precompute_command
    )
    app.command("install", epilog="Example: [bold]motionsplice install bank /srv/bank[/bold]")(install_command)
    app.command("inspect", epilog="Example: [bold]motionsplice inspect bank[/bold]")(inspect_command)


def precompute_command(
    clips: Annotated[
        list[str], typer.Argument(help="Motion files (.bvh, .fbx, .glb, ...), folders of them, or their URLs.")
    ],
    out: Annotated[str, typer.Option(help="The bank to write, a folder or a URL.")],
    baseline: Annotated[
        str, typer.Option(help="The clip to whose stride all clips are aligned; auto: the most typical stride.")
    ] = AUTOMATIC,
    jobs: Annotated[int | None, typer.Option(min=1, help="Number of processes; default: one per core.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="tcp://HOST:PORT of a Dask scheduler, whose workers do the work instead.")
    ] = None,
    roles: RolesFile = None,
    hands: Annotated[
        list[str] | None, typer.Option(help="BODY:HANDS: lay the hands of clip HANDS on clip BODY.")
    ] = None,
    skeleton: Annotated[
        str | None,
        typer.Option(help="A motion file, character or bank whose skeleton the bank gets; default: the baseline's."),
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
    rate, root and roles file of each clip. A hands.toml lists which hands are laid on which bodies, and how. If a clip
    fails, its reason is printed, the others finish, and the exit status is 1.
    """
    from motionsplice.precompute.hands.settings import HandsOnBody

    file = ProgressFile(progress) if progress is not None else None
    places, bank = [place_of(one) for one in clips], place_of(out)
    try:
        outcome = run(
            places,
            bank,
            baseline=None if baseline == AUTOMATIC else baseline,
            jobs=jobs,
            scheduler=scheduler,
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
    print_work(outcome, bank)
    print_left_out(places)
    if isinstance(bank, Remote):
        console.print(f"bank {outcome.digest}", highlight=False)
    elif not outcome.unchanged:
        built = Bank.open(bank)
        show_tables(built)
        print_retargeted(built, skeleton)
    print_grouped("red", reasons_of(outcome.failed), [*outcome.clips, *outcome.failed], verb=" failed", to=messages)
    if outcome.failed:
        if roles is not None:
            messages.print("--roles applies to all clips. For a few, set `roles` in clips.toml", soft_wrap=True)
        raise typer.Exit(1)


def run(
    clips: Sequence[Path | Remote],
    out: Path | Remote,
    *,
    baseline: str | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    settings: ClipSettings = DEFAULT_SETTINGS,
    roles_file: Path | None = None,
    hands: Sequence[HandsOnBody] = (),
    skeleton: str | None = None,
    retarget: bool = True,
    file: ProgressFile | None = None,
) -> Outcome:
    """Runs the offline job behind a progress bar. Raises MotionError."""
    from motionsplice.motion.roles import read_roles_file
    from motionsplice.precompute.job.job import build_bank

    with stages(file) as show, _workers(scheduler) as executor:
        return build_bank(
            clips,
            out,
            baseline=baseline,
            jobs=jobs or os.cpu_count() or 1,
            executor=executor,
            settings=settings,
            roles=read_roles_file(roles_file) if roles_file else {},
            hands=hands,
            skeleton=skeleton,
            retarget=retarget,
            progress=show,
        )


def _workers(scheduler: str | None) -> AbstractContextManager[Executor | None]:
    """Returns the executor of a scheduler, if one is named. Entering it raises SettingsError."""
    if scheduler is None:
        return nullcontext()
    from motionsplice.precompute.job.scheduler import executor_of

    return executor_of(scheduler)


@contextmanager
def stages(file: ProgressFile | None = None) -> Iterator[Callable[[str, int, int], None]]:
    """Shows a bar for each stage of a job, and writes the progress to a file."""
    columns = (TextColumn("{task.description:>9}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    bar, tasks = Progress(*columns, console=messages), dict[str, TaskID]()
    with ExitStack() as shown:

        def show(stage: str, done: int, total: int) -> None:
            if not tasks:  # one without a stage would print an empty line
                shown.enter_context(bar)
            if stage not in tasks:  # a stage without work has no bar
                tasks[stage] = bar.add_task(stage)
            bar.update(tasks[stage], completed=done, total=total)
            if file is not None:
                file.show(stage, done, total)

        yield show


def print_work(outcome: Outcome, out: Path | Remote) -> None:
    """Prints how many clips were processed, and how many were reused or failed."""
    count = f"{len(outcome.clips)} clip{'s' * (len(outcome.clips) != 1)}"
    if outcome.unchanged:
        line = f"{out}: nothing to do, none of its {count} changed"
    else:
        line = f"{count}, {outcome.reused} reused"
    failed = f", {len(outcome.failed)} failed" if outcome.failed else ""
    console.print(line + failed, highlight=False, soft_wrap=True)


def print_left_out(clips: Sequence[Path | Remote]) -> None:
    """Prints which motion files in the folders cannot be read, and which subfolders have some."""
    from motionsplice.motion.errors import listed
    from motionsplice.motion.formats.files import folders_of_clips, other_files

    sentences = []
    if others := [file.name for path in clips if path.is_dir() for file in other_files(path)]:
        sentences.append(f"left out, cannot be read: {listed(others)}. Export them as BVH or GLB")
    folders = [path for path in clips if isinstance(path, Path) and path.is_dir()]
    if below := [str(one) for path in folders for one in folders_of_clips(path) if one not in folders]:
        mend = "Name them too if their clips belong to the bank"
        sentences.append(f"left out, subfolders are not searched: {listed(below)}. {mend}")
    print_sentences(messages, "yellow", sentences)


def print_retargeted(bank: Bank, skeleton: str | None) -> None:
    """Prints how many clips were retargeted, and how to see the notes."""
    from motionsplice.motion.retarget.onto_rig import RETARGETED

    notes = notes_of(bank)
    if moved := sum(sentence.startswith(RETARGETED) for _, sentence in notes):
        rig = f"the skeleton of {skeleton or repr(bank.baseline.clip)}"
        other = "" if skeleton else "; choose another with --skeleton"
        line = f"{moved} of {len(bank.clips)} clips were retargeted to {rig}{other}"
        console.print(line, highlight=False, soft_wrap=True, markup=False)
    if notes:
        line = f"`motionsplice inspect {bank.path}` prints the notes on the clips"
        console.print(line, style="dim", highlight=False, soft_wrap=True, markup=False)


def install_command(
    bank: Annotated[str, typer.Argument(help="A bank, as `precompute` wrote it: a folder or a URL.")],
    place: Annotated[str, typer.Argument(help="The folder or URL to copy it to; it may hold a bank that is served.")],
) -> None:
    """Copy a bank to where it is served, in place of an older one.

    The copy is verified. Files of the bank that is there are not changed while it is in use; the new manifest comes
    last. A service with --watch then serves the new bank.
    """
    from motionsplice.precompute.job.install import install_bank

    with stages() as show:
        digest = install_bank(place_of(bank), place_of(place), show)
    console.print(f"{place}: bank {digest}", highlight=False, soft_wrap=True)


def inspect_command(bank: Annotated[Path, typer.Argument(help="A bank, as `precompute` wrote it.")]) -> None:
    """Show the clips of a bank, and how well each is aligned to the baseline."""
    opened = Bank.open(bank)
    show_tables(opened)
    print_grouped("dim", [*notes_of(opened), *uneven_clips(opened)], [clip.name for clip in opened.clips])
