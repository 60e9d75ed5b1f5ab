"""The service under load: `python -m bench.service [WHAT]`; all of it without a word.

The server runs in a process of its own and the clients in another, over 127.0.0.1, on a generated bank of 40 clips of
10 s and 31 joints. Whatever is compared runs in turns. A share of a core, and what is told per core, is of the
computing time of the server's process, the system's part included: the clients' part of the machine does not count.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from bench.generated import generate
from bench.service import batch, crowd, poses, streams
from bench.service.cast import BANK
from bench.service.tables import show_targets
from bench.targets import Target
from motionsplice.cli import run

app = typer.Typer(help=__doc__, add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
Seconds = Annotated[float, typer.Option(min=1.0, help="Of each run")]
Rounds = Annotated[int, typer.Option(min=1, help="In which runs take turns")]
Check = Annotated[bool, typer.Option("--check", help="Exit with 1 if a figure is not what is wanted")]


@app.callback(invoke_without_command=True)
def all_commands(context: typer.Context, check: Check = False) -> None:
    """The service under load. Without a command, all of them."""
    if context.invoked_subcommand is None:
        told(check, lambda bank: streams.measure(bank, 64, 1, 10.0, 3))


@app.command("streams")
def streams_command(
    connections: Annotated[int, typer.Option(min=1)] = 64,
    characters: Annotated[int, typer.Option(min=1, help="Of each connection")] = 1,
    seconds: Seconds = 10.0,
    rounds: Rounds = 3,
    check: Check = False,
) -> None:
    """How regularly frames come, against a bare uvicorn that sends constant bytes."""
    told(check, lambda bank: streams.measure(bank, connections, characters, seconds, rounds))


@app.command("crowd")
def crowd_command(
    characters: Annotated[int, typer.Option(min=1)] = 4000,
    seconds: Seconds = 4.0,
    rounds: Rounds = 3,
    check: Check = False,
) -> None:
    """Thousands of characters on one stream, and what one of their frames costs."""
    told(check, lambda bank: crowd.measure(bank, characters, seconds, rounds))


@app.command("poses")
def poses_command(
    connections: Annotated[int, typer.Option(min=1)] = 32,
    seconds: Seconds = 4.0,
    rounds: Rounds = 3,
    check: Check = False,
) -> None:
    """Single poses: GET /v1/pose."""
    told(check, lambda bank: poses.measure(bank, connections, seconds, rounds))


@app.command("batch")
def batch_command(
    characters: Annotated[int, typer.Option(min=1)] = 1000,
    seconds: Seconds = 4.0,
    rounds: Rounds = 3,
    check: Check = False,
) -> None:
    """Poses of many characters: POST /v1/poses."""
    told(check, lambda bank: batch.measure(bank, characters, seconds, rounds))


def told(check: bool, *measures: Callable[[Path], list[Target]]) -> None:
    """Runs measurements on a generated bank, and says whether they are as wanted."""
    with tempfile.TemporaryDirectory() as folder:
        bank = generate(Path(folder) / "bank", BANK).path
        found = [target for measure in measures for target in measure(bank)]
    show_targets(found)
    if check and not all(one.met for one in found):
        raise typer.Exit(1)


if __name__ == "__main__":
    run(app)
