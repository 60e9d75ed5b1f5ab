"""Profiles the server: `python -m bench.service.profile [poses | batches | streams | crowd]`.

cProfile makes calls of Python functions slower, but not compiled code, and its clock also runs while another process
has the core. So the table shows where to look first, and its title shows the cost of an answer without the profiler.
The event loop itself, which waits and reads from sockets, is not in the table.
"""

from __future__ import annotations

import os
import pstats
import signal
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from bench.service.banks import built_in, names
from bench.service.clients import Streams, ask, create
from bench.service.crowd import CHARACTERS
from bench.service.process import PATIENCE, Process, profiled
from bench.service.requests import CONNECTIONS, batch_request, queries
from bench.service.stream_client import Job
from bench.service.streams import PATH
from motionsplice.cli import run
from motionsplice.motion.errors import SettingsError, did_you_mean

SETTLING = 4.0  # seconds for clients to start and create characters
LOOP = "run_until_complete"
CONNECTED = 64  # streams
ANSWERED, SENT = 'motionsplice_requests_total{route="%s",status="200"}', "motionsplice_frames_sent_total"


@dataclass(frozen=True)
class Load:
    """A function that loads the server for some seconds, and the metric that counts the answers."""

    ask: Callable[[Process, Path, float], object]
    counter: str


@dataclass(frozen=True)
class Cost:
    """A function's own seconds, without the functions it called, and its number of calls."""

    where: str
    seconds: float
    calls: int


@dataclass(frozen=True)
class Profile:
    """Processor seconds per answer without the profiler; functions by cost, and the answers while profiling."""

    seconds: float
    costs: list[Cost]
    answers: float


def main(
    what: Annotated[list[str] | None, typer.Argument(help="Loads to profile; default: all.")] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Seconds with and without the profiler")] = 5.0,
    most: Annotated[int, typer.Option(min=1, help="Number of functions to print")] = 15,
) -> None:
    """Prints the most expensive functions of the service under each load."""
    for name in what or LOADS:
        if name not in LOADS:
            raise SettingsError(f"unknown load {name!r}", mend=did_you_mean(name, LOADS))
        with tempfile.TemporaryDirectory() as folder:
            show(name, profile(built_in(Path(folder)), LOADS[name], seconds), most)


def profile(bank: Path, load: Load, seconds: float) -> Profile:
    """Loads a server for `seconds` without the profiler, and then for as long with it."""
    file = bank.parent / "profile"
    with profiled(bank, file, "--max-load", "1000000000") as server:
        asking = Thread(target=load.ask, args=(server, bank, SETTLING + 2.0 * seconds + 1.0))
        asking.start()
        time.sleep(SETTLING)
        spent, plain = -server.cpu(), -server.metric(load.counter)
        time.sleep(seconds)
        spent, plain = spent + server.cpu(), plain + server.metric(load.counter)
        answers = -server.metric(load.counter)
        os.kill(server.pid, signal.SIGUSR1)
        time.sleep(seconds)
        os.kill(server.pid, signal.SIGUSR2)
        answers += server.metric(load.counter)
        asking.join()
        deadline = time.monotonic() + PATIENCE
        while not file.exists():
            if time.monotonic() > deadline:
                raise SettingsError(f"the server did not write its profile within {PATIENCE:g} s")
            time.sleep(0.05)
    if not plain or not answers:
        raise SettingsError("the clients got no answers")
    return Profile(spent / plain, costs(pstats.Stats(str(file)).stats), answers)  # type: ignore[attr-defined]


def costs(stats: Mapping[tuple[str, int, str], tuple[Any, ...]]) -> list[Cost]:
    """Returns the functions of cProfile's statistics by their own time, without the event loop, which also sleeps."""
    found = []
    for (file, line, name), (_, calls, own, *_) in stats.items():
        if LOOP not in name:
            place = f"{'/'.join(Path(file).parts[-2:])}:{line} " if line else ""
            found.append(Cost(f"{place}{name}", own, calls))
    return sorted(found, key=lambda one: one.seconds, reverse=True)


def show(name: str, found: Profile, most: int) -> None:
    """Prints the `most` most expensive functions."""
    whole = sum(one.seconds for one in found.costs)
    plain, with_profiler = 1e6 * found.seconds, 1e6 * whole / found.answers
    title = f"{name}: {plain:.0f} us per answer or message; {with_profiler:.0f} us with the profiler"
    table = Table(title=title, title_justify="left")
    for column in ("", "us", "share", "calls"):
        table.add_column(column, justify="right" if table.columns else "left", no_wrap=True)
    others = Cost("all other functions", sum(one.seconds for one in found.costs[most:]), 0)
    for one in (*found.costs[:most], others):
        calls = f"{one.calls / found.answers:.2f}" if one.calls else ""
        table.add_row(
            one.where, f"{1e6 * one.seconds / found.answers:.2f}", f"{100.0 * one.seconds / whole:.0f} %", calls
        )
    Console(width=120).print(table)


def _poses(server: Process, bank: Path, seconds: float) -> None:
    ask(server, queries(names(bank, "locomotion"), names(bank, "action"), "msgpack"), CONNECTIONS, seconds)


def _batches(server: Process, bank: Path, seconds: float) -> None:
    ask(server, [batch_request(bank, "float32")], 1, seconds)


def _streams(server: Process, bank: Path, seconds: float) -> None:
    _take(server, bank, CONNECTED, 1, seconds)


def _crowd(server: Process, bank: Path, seconds: float) -> None:
    _take(server, bank, 1, CHARACTERS, seconds)


def _take(server: Process, bank: Path, connections: int, characters: int, seconds: float) -> None:
    commands = create(characters, names(bank, "locomotion"), names(bank, "action"))
    Streams(Job(server.port, PATH, connections, seconds, commands)).taken()


LOADS = {
    "poses": Load(_poses, ANSWERED % "/v1/pose"),
    "batches": Load(_batches, ANSWERED % "/v1/poses"),
    "streams": Load(_streams, SENT),
    "crowd": Load(_crowd, SENT),
}


if __name__ == "__main__":
    run(lambda: typer.run(main))
