"""Where the server's time goes: `python -m bench.service.profile [poses | batches | streams | crowd]`.

cProfile makes each call of a Python function dearer, and compiled work not; and while something else has the core, its
clock goes on. So its table says what to look at first, and the title what an answer costs without it. What the event
loop does itself, which is to wait and to read from sockets, is not in the table.
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

SETTLING = 4.0  # seconds that clients have to start in and to make characters
LOOP = "run_until_complete"
CONNECTED = 64  # streams
ANSWERED, SENT = 'motionsplice_requests_total{route="%s",status="200"}', "motionsplice_frames_sent_total"


@dataclass(frozen=True)
class Load:
    """Clients that ask for some seconds, and the metric that counts what they get."""

    ask: Callable[[Process, Path, float], object]
    counter: str


@dataclass(frozen=True)
class Cost:
    """A function: seconds that it took itself, without what it called, and how often it was called."""

    where: str
    seconds: float
    calls: int


@dataclass(frozen=True)
class Profile:
    """Seconds of computing time an answer without the profile; functions, the dearest first; answers meanwhile."""

    seconds: float
    costs: list[Cost]
    answers: float


def main(
    what: Annotated[list[str] | None, typer.Argument(help="Loads; all of them if not said.")] = None,
    seconds: Annotated[float, typer.Option(min=1.0)] = 5.0,
    most: Annotated[int, typer.Option(min=1, help="Functions that are shown")] = 15,
) -> None:
    """Print what is dearest in the service under each load."""
    for name in what or LOADS:
        if name not in LOADS:
            raise SettingsError(f"there is no load {name!r}", mend=did_you_mean(name, LOADS))
        with tempfile.TemporaryDirectory() as folder:
            show(name, profile(built_in(Path(folder)), LOADS[name], seconds), most)


def profile(bank: Path, load: Load, seconds: float) -> Profile:
    """A server under a load: first for some time as it is, then for as long with its profile taken."""
    file = bank.parent / "profile"
    with profiled(bank, file, "--max-load", "1e9") as server:
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
                raise SettingsError("the server does not write its profile")
            time.sleep(0.05)
    if not plain or not answers:
        raise SettingsError("the clients got no answers")
    return Profile(spent / plain, costs(pstats.Stats(str(file)).stats), answers)  # type: ignore[attr-defined]


def costs(stats: Mapping[tuple[str, int, str], tuple[Any, ...]]) -> list[Cost]:
    """Of what cProfile noted, functions by what they took themselves; not the event loop, which also sleeps."""
    found = []
    for (file, line, name), (_, calls, own, *_) in stats.items():
        if LOOP not in name:
            place = f"{'/'.join(Path(file).parts[-2:])}:{line} " if line else ""
            found.append(Cost(f"{place}{name}", own, calls))
    return sorted(found, key=lambda one: one.seconds, reverse=True)


def show(name: str, found: Profile, most: int) -> None:
    """Prints the dearest functions."""
    whole = sum(one.seconds for one in found.costs)
    title = f"{name}: {1e6 * found.seconds:.0f} us an answer or message; {1e6 * whole / found.answers:.0f} while noted"
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
