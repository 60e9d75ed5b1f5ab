"""`python -m bench.service [WHAT ...] [--soak] [--check]`: what the service does under load.

A server and its clients run on this machine, in processes of their own, in turns with a control that does nothing but
send. --soak runs for minutes; --check ends with status 1 if a figure is not what is wanted.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from bench.findings import Findings
from bench.service.banks import built_in
from bench.service.crowd import crowd
from bench.service.exchange import exchange
from bench.service.harm import connects, stalled
from bench.service.requests import batches, poses
from bench.service.streams import streams
from motionsplice.cli import run
from motionsplice.motion.errors import SettingsError, did_you_mean

Measure = Callable[[Path], Findings]
SHORT: dict[str, Measure] = {
    "streams": streams,
    "crowd": crowd,
    "poses": poses,
    "batches": batches,
    "stalled": stalled,
    "connects": connects,
    "exchange": exchange,
}
LONG: dict[str, Measure] = {
    "streams": lambda bank: streams(bank, seconds=60.0, rounds=5),
    "crowd": lambda bank: crowd(bank, seconds=60.0),
    "stalled": lambda bank: stalled(bank, seconds=60.0, rounds=3),
    "connects": lambda bank: connects(bank, times=20_000),
    "exchange": lambda bank: exchange(bank, exchanges=200),
}


def main(
    what: Annotated[list[str] | None, typer.Argument(help="What to measure; all of it if not said.")] = None,
    soak: Annotated[bool, typer.Option(help="For minutes instead of seconds.")] = False,
    check: Annotated[bool, typer.Option(help="Fail if a figure is not what is wanted.")] = False,
) -> None:
    """Measure the service under load."""
    measures, missed = LONG if soak else SHORT, []
    for name in what or measures:
        if name not in measures:
            raise SettingsError(f"there is nothing called {name!r}", mend=did_you_mean(name, measures))
        with tempfile.TemporaryDirectory() as folder:
            found = measures[name](built_in(Path(folder)))
        found.show()
        missed += found.missed
    for one in missed:
        print(one)
    if missed and check:
        raise typer.Exit(1)


if __name__ == "__main__":
    run(lambda: typer.run(main))
