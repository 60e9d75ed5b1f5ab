"""The command `motionsplice`.

Listing the commands imports none of them: each module is imported when its command is used.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from typer.core import TyperCommand

from motionsplice import __version__
from motionsplice.motion.errors import MotionError

COMMANDS = {  # each command's module in `motionsplice.commands`, and the first line of its help
    "precompute": ("bank", "Align clips to a baseline locomotion, and write a bank."),
    "install": ("bank", "Copy a bank to where it is served, in place of an older one."),
    "inspect": ("bank", "Show the clips of a bank, and how well each is aligned to the baseline."),
    "splice": (
        "motion",
        "Splice an action's upper body onto a locomotion, and write the motion as BVH, glTF or VRM animation.",
    ),
    "convert": ("convert", "Read a motion file, print what was understood, and write it in another format."),
    "render": ("motion", "Draw motions as stick figures, or one hand of each, to judge them by eye."),
    "hands": ("hands", "Align hands to a body that was captured separately, and write the body with their fingers."),
    "study": ("study", "Find which upper-body motions correlate with the legs, and which of them other motions keep."),
    "send": ("send", "Play a character in real time to programs that receive VMC or JSON Live Link."),
    "serve": ("serve", "Serve a bank's clips, poses, splices and streams over HTTP until stopped."),
    "demo": ("demo", "Build a bank of the built-in motions, splice one, add hands to another, draw both, and serve."),
}

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)


class LazyCommand(TyperCommand):
    """A command's name and one line of help; the rest is imported when the command is used."""

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        assert self.name is not None
        return _load(self.name).make_context(info_name, args, parent, **extra)


def _load(name: str) -> Any:
    """Imports a command's module, and returns the command."""
    if name == "precompute":  # its matrix products are so small that more threads only take time from others
        from motionsplice.precompute.job.processes import ONE_THREAD  # imports no NumPy, at which BLAS reads this

        os.environ.update(ONE_THREAD | os.environ)
    module = import_module(f"motionsplice.commands.{COMMANDS[name][0]}")
    group = typer.Typer(rich_markup_mode="rich", pretty_exceptions_enable=False)
    group.callback()(_nothing)  # makes it a group even if the module has one command
    module.register(group)
    return typer.main.get_group(group).commands[name]


def _nothing() -> None:
    pass


for _name, (_, _help) in COMMANDS.items():
    app.command(_name, help=_help, cls=LazyCommand)(_nothing)


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"motionsplice {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_show_version, help="Show the version and exit.")
    ] = False,
) -> None:
    """Splice the upper body of any motion clip onto the lower body of any other."""


def main() -> None:
    """Runs the command line."""
    run(app)


def run(command: Callable[[], object]) -> None:
    """Runs a command. An error that the user can correct is printed as one paragraph, and the exit status is 1."""
    try:
        command()
    except MotionError as error:
        _fail(str(error))
    except OSError as error:
        _fail(f"{error.filename or 'the system'}: {error.strerror or error}")
    except KeyboardInterrupt:
        sys.exit(130)


def _fail(problem: str) -> None:
    console = Console(stderr=True, emoji=False)
    console.print(f"[bold red]error:[/bold red] {escape(problem)}", highlight=False, soft_wrap=True)
    sys.exit(1)
