"""Measures the service under load: `python -m bench.service [WHAT ...] [--soak] [--check]`.

The server and its clients run on this machine, in separate processes. Where it helps, they alternate with a control: a
server that only sends. --soak measures for minutes. --check exits with status 1 if a figure misses its target.

streams      Are 64 streams of one character even, complete and cheap?
crowd        What does one stream of 4,000 characters cost?
saturation   Do 200 to 1,000 streams share one core evenly, and how many messages does it send?
poses        How many single poses per second does the server answer, and how long do they take?
batches      What does a request of 1,000 poses cost, beyond evaluating and encoding it?
stalled      Do clients that stop reading disturb others, and are they closed?
floods       Do long lists of commands, pings or big batches disturb other clients?
connects     Do clients that connect and abort leave anything behind?
exchange     Do streams stay intact while the bank is exchanged?
descriptors  Do streams go on, and is a new bank served, though clients took all descriptors?
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
from bench.service.descriptors import descriptors
from bench.service.exchange import exchange
from bench.service.floods import floods
from bench.service.harm import connects, stalled
from bench.service.requests import batches, poses
from bench.service.saturation import saturation
from bench.service.streams import streams
from motionsplice.cli import run
from motionsplice.motion.errors import SettingsError, did_you_mean

Measure = Callable[[Path], Findings]
SHORT: dict[str, Measure] = {
    "streams": streams,
    "crowd": crowd,
    "saturation": saturation,
    "poses": poses,
    "batches": batches,
    "stalled": stalled,
    "floods": floods,
    "connects": connects,
    "exchange": exchange,
    "descriptors": descriptors,
}
LONG: dict[str, Measure] = {
    "streams": lambda bank: streams(bank, seconds=60.0, rounds=5),
    "crowd": lambda bank: crowd(bank, seconds=60.0),
    "saturation": lambda bank: saturation(bank, seconds=30.0),
    "stalled": lambda bank: stalled(bank, seconds=60.0, rounds=3),
    "floods": lambda bank: floods(bank, seconds=30.0, rounds=5),
    "connects": lambda bank: connects(bank, times=20_000),
    "exchange": lambda bank: exchange(bank, exchanges=1000),
    "descriptors": lambda bank: descriptors(bank, seconds=60.0),
}


def main(
    what: Annotated[list[str] | None, typer.Argument(help="What to measure; default: everything.")] = None,
    soak: Annotated[bool, typer.Option(help="Measure for minutes instead of seconds.")] = False,
    check: Annotated[bool, typer.Option(help="Exit with status 1 if a figure misses its target.")] = False,
) -> None:
    """Measures the service under load."""
    measures, missed = LONG if soak else SHORT, []
    for name in what or measures:
        if name not in measures:
            raise SettingsError(f"unknown measurement {name!r}", mend=did_you_mean(name, measures))
        with tempfile.TemporaryDirectory() as folder:
            findings = measures[name](built_in(Path(folder)))
        findings.show()
        missed += findings.missed
    for sentence in missed:
        print(sentence)
    if missed and check:
        raise typer.Exit(1)


if __name__ == "__main__":
    run(lambda: typer.run(main))
