"""The command `motionsplice`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from motionsplice import __version__
from motionsplice.commands import bank as command_bank
from motionsplice.commands import demo as command_demo
from motionsplice.commands import hands as command_hands
from motionsplice.commands import motion as command_motion
from motionsplice.commands import serve as command_serve
from motionsplice.commands import study as command_study
from motionsplice.motion.errors import MotionError

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)
for group in (command_bank, command_motion, command_hands, command_study, command_serve, command_demo):
    group.register(app)


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
    """Runs a command. What a user can mend is told in one paragraph, and the exit status is 1."""
    try:
        command()
    except MotionError as error:
        _tell(str(error))
    except OSError as error:
        _tell(f"{error.filename or 'the system'}: {error.strerror or error}")
    except KeyboardInterrupt:
        sys.exit(130)


def _tell(problem: str) -> None:
    console = Console(stderr=True, emoji=False)
    console.print(f"[bold red]error:[/bold red] {escape(problem)}", highlight=False, soft_wrap=True)
    sys.exit(1)
