"""`motionsplice demo`: the whole workflow on the built-in motions."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from motionsplice.commands import bank as command_bank
from motionsplice.commands import hands as command_hands
from motionsplice.commands import serve as command_serve
from motionsplice.commands.bank_report import show_tables
from motionsplice.commands.motion import Method, Posture, spliced
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import truth
from motionsplice.motion.samples import write_sample_clips, write_sample_gestures
from motionsplice.pictures.sheets import animation, contact_sheet
from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings

LOCOMOTION, ACTION = "curve", "carry_cup"
BODY, HANDS = "count_steps", "count_steps_hands"
SHEET = (0.5, 3.0)  # first and last second on the contact sheet

console = Console(emoji=False)


def register(app: typer.Typer) -> None:
    app.command("demo", epilog="Example: [bold]motionsplice demo demo[/bold]")(demo_command)


def demo_command(
    folder: Annotated[Path, typer.Argument(help="Folder for clips, bank and results.")] = Path("demo"),
) -> None:
    """Build a bank of the built-in motions, splice one, add hands to another, draw both, and serve."""
    clips, bank_folder, gestures = folder / "clips", folder / "bank", folder / "gestures"
    write_sample_clips(clips)
    write_sample_gestures(gestures)
    command_bank.print_work(command_bank.run([clips], bank_folder, baseline="walk"), bank_folder)
    bank = Bank.open(bank_folder)
    show_tables(bank)
    splice = spliced(bank, LOCOMOTION, ACTION, Method.SPLICE, Posture.RELATIVE, 0.0)
    naive = spliced(bank, LOCOMOTION, ACTION, Method.NAIVE, Posture.RELATIVE, 0.0)
    motion = folder / f"{LOCOMOTION}+{ACTION}.bvh"
    motion.write_bytes(dump_bvh(splice))
    real = truth(LOCOMOTION, ACTION)
    rows = [("naive splice", naive, bank.roles), ("motionsplice", splice, bank.roles), ("truth", real, bank.roles)]
    sheet, film = motion.with_suffix(".png"), motion.with_suffix(".gif")
    contact_sheet(rows, start=SHEET[0], end=SHEET[1], ghost=real).save(sheet)
    film.write_bytes(animation(rows, end=4.0, ghost=real))
    console.print(f"\n{ACTION!r} spliced onto {LOCOMOTION!r}, a motion that was never captured:")
    for what, file in (("motion", motion), ("picture", sheet), ("animation", film), ("bank", bank_folder)):
        console.print(f"  {what:9} {file}", highlight=False)
    hands, counting = (gestures / f"{name}.bvh" for name in (HANDS, BODY))
    merged = folder / f"{BODY}+hands.bvh"
    console.print(f"\n{HANDS!r}, captured separately, laid on {BODY!r}:")
    command_hands.hands_command(counting, hands, merged, hand="right", picture=merged.with_suffix(".png"))
    settings = Settings()
    if sys.stdout.isatty():
        serve(bank_folder, settings)
    else:
        console.print(f"\n`motionsplice serve {bank_folder}` serves it at http://{settings.host}:{settings.port}/view")


def serve(bank: Path, settings: Settings) -> None:
    """Serves the demo's bank. Raises MotionError; the mend names a command, because `demo` has no such options."""
    try:
        command_serve.start(bank, settings)
    except SettingsError as error:
        mend = f"The files are written: `motionsplice serve {bank} --port 0` serves them on a free port"
        raise SettingsError(error.problem, file=error.file, place=error.place, mend=mend) from None
