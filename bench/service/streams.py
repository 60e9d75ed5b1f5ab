"""Many WebSockets at 60 Hz, in turns with as many of a bare uvicorn that sends constant bytes."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import uvloop

from bench.precompute import in_process
from bench.service.cast import CHARACTERS, cast
from bench.service.control import control
from bench.service.jitter import Jitter, jitter
from bench.service.player import Player, connect, numbered
from bench.service.servers import Endpoint, service
from bench.service.tables import MEGABYTE, at_most, milliseconds, percent, show
from bench.targets import Target

RATE = 60.0
SETTLING = 1.0  # seconds before anything is noted


@dataclass(frozen=True)
class Streamed:
    """One run: shares of a core that the server and the client took, bytes of a message, of the server's memory."""

    jitter: Jitter
    per_second: float
    cpu: float
    client_cpu: float
    message: int
    memory: int


def measure(bank: Path, connections: int, characters: int, seconds: float, rounds: int) -> list[Target]:
    """Prints both, and says whether the service is as regular as the control."""
    with service(bank) as ours:
        size = in_process(load, ours, 1, characters, 1.0).message
        with control("uvicorn", size) as other:
            runs: dict[str, list[Streamed]] = {"motionsplice": [], "bare uvicorn": []}
            for _ in range(rounds):
                runs["motionsplice"].append(in_process(load, ours, connections, characters, seconds))
                runs["bare uvicorn"].append(in_process(load, other, connections, 0, seconds))
    columns = ["ms", "off the grid", "p99", "worst", "off 1/60 s", "p99", "lost", "frames/s", "CPU", "client", "MB"]
    title = f"{connections} WebSockets of {characters} characters, {RATE:g} Hz, {rounds} x {seconds:g} s, {size} bytes"
    show(title, columns, [_row(name, some) for name, some in runs.items()])
    pairs = list(zip(*runs.values(), strict=True))
    grid = median(one.jitter.off_grid_p99 / other.jitter.off_grid_p99 for one, other in pairs)
    between = median(one.jitter.off_interval_p99 / other.jitter.off_interval_p99 for one, other in pairs)
    return [
        at_most("streams: p99 off the grid over the control's", grid, 1.3),
        at_most("streams: p99 off 1/60 s over the control's", between, 1.3),
        at_most("streams: frames lost", sum(one.jitter.lost for one in runs["motionsplice"]), 0),
    ]


def load(endpoint: Endpoint, connections: int, characters: int, seconds: float) -> Streamed:
    """Takes frames for a while; `characters` 0 is of the control, which has no commands."""
    return uvloop.run(_load(endpoint, connections, characters, seconds))


async def _load(endpoint: Endpoint, connections: int, characters: int, seconds: float) -> Streamed:
    players = [Player(CHARACTERS, numbered if characters else None) for _ in range(connections)]
    for seed, player in enumerate(players):
        await connect(endpoint, player)
        if characters:
            await player.do(cast(characters, seed))
    await asyncio.sleep(SETTLING)
    for player in players:
        player.forget()
    began, own, theirs = perf_counter(), process_time(), endpoint.cpu_seconds
    await asyncio.sleep(seconds)
    lasted, own, theirs = perf_counter() - began, process_time() - own, endpoint.cpu_seconds - theirs
    memory = endpoint.memory
    found = jitter([player.arrivals for player in players], RATE)
    messages = sum(len(player.arrivals.times) for player in players)
    size = sum(player.received for player in players) // messages
    for player in players:
        player.transport.abort()
    return Streamed(found, messages / lasted, theirs / lasted, own / lasted, size, memory)


def _row(name: str, runs: list[Streamed]) -> list[str]:
    """Medians over runs; of what is lost and worst, all."""
    jitters = [one.jitter for one in runs]
    fields = ("off_grid", "off_grid_p99", "worst", "off_interval", "off_interval_p99")
    return [
        name,
        *(milliseconds(median(getattr(one, field) for one in jitters)) for field in fields),
        str(sum(one.lost for one in jitters)),
        f"{median(one.per_second for one in runs):.0f}",
        *(percent(median(values)) for values in ([one.cpu for one in runs], [one.client_cpu for one in runs])),
        f"{runs[-1].memory / MEGABYTE:.0f}",
    ]
