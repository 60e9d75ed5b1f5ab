"""One stream of thousands of characters: at 60 Hz, and as many frames as a core can send."""

from __future__ import annotations

import asyncio
import socket
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import uvloop

from bench.precompute import in_process
from bench.service.asking import ask, post
from bench.service.batch import BODIES, MEDIA_TYPE, Crowd
from bench.service.cast import BANK, CHARACTERS, cast, clip_names
from bench.service.jitter import lost
from bench.service.player import Player, connect, numbered
from bench.service.servers import Endpoint, service
from bench.service.tables import at_least, at_most, percent, show
from bench.targets import Target

PACED, FASTEST = 60.0, 1000.0  # frames per second
SETTLING = 1.0  # seconds before anything is noted
FREE = ("--max-rate", f"{FASTEST:g}", "--max-load", "1e9")  # what would otherwise hold the service back
ENCODINGS = ("float32", "int16")
RECEIVED = 2**20  # bytes taken from a socket at once


@dataclass(frozen=True)
class Sent:
    """One run: frames of characters that came, those that did not, bytes, and shares of a core."""

    frames: int
    lost: int
    seconds: float
    cpu: float
    client_cpu: float
    bytes: int

    @property
    def per_core(self) -> float:
        """Frames of characters per second of the server's computing time."""
        return self.frames / self.seconds / self.cpu


def measure(bank: Path, characters: int, seconds: float, rounds: int) -> list[Target]:
    """Prints what a frame of a character costs in every form in which it is sent, and whether that is as wanted."""
    runs: dict[str, list[Sent]] = {}
    with service(bank, *FREE) as ours:
        for _ in range(rounds):
            for form in ENCODINGS:
                for what, sent in {
                    f"WebSocket, {PACED:g} Hz": in_process(take, ours, characters, form, PACED, seconds),
                    f"WebSocket, {FASTEST:g} Hz": in_process(take, ours, characters, form, FASTEST, seconds),
                    f"POST /v1/poses of {characters}": in_process(ask_for_all, ours, characters, form, seconds),
                    "GET /v1/stream of one": in_process(take_stream, ours, form, seconds),
                }.items():
                    runs.setdefault(f"{what}, {form}", []).append(sent)
    columns = ["", "per s", "per s and core", "ns of a core", "CPU", "client", "bytes", "MB/s", "not sent"]
    show(f"frames of characters, {rounds} x {seconds:g} s", columns, [_row(name, some) for name, some in runs.items()])
    paced = runs[f"WebSocket, {PACED:g} Hz, float32"]
    targets = [
        at_most("crowd: share of a core at 60 Hz", median(one.cpu for one in paced), 0.5),
        at_most("crowd: frames lost at 60 Hz", sum(one.lost for one in paced), 0),
    ]
    for name in (f"POST /v1/poses of {characters}", f"WebSocket, {FASTEST:g} Hz"):
        per_core = [one.per_core for one in runs[f"{name}, float32"]]
        targets.append(at_least(f"crowd: frames per second and core, {name}", median(per_core), 1e6))
    return targets


def take(endpoint: Endpoint, characters: int, form: str, rate: float, seconds: float) -> Sent:
    """From a WebSocket. Of frames that the client is too slow for, only the newest come."""
    return uvloop.run(_take(endpoint, characters, form, rate, seconds))


async def _take(endpoint: Endpoint, characters: int, form: str, rate: float, seconds: float) -> Sent:
    player = Player(f"{CHARACTERS}?rate={rate:g}&encoding={form}", numbered)
    await connect(endpoint, player)
    await player.do(cast(characters, 0))
    await asyncio.sleep(SETTLING)
    player.forget()
    began, own, theirs = perf_counter(), process_time(), endpoint.cpu_seconds
    await asyncio.sleep(seconds)
    lasted, own, theirs = perf_counter() - began, process_time() - own, endpoint.cpu_seconds - theirs
    arrivals = player.arrivals
    frames, gone = characters * sum(arrivals.counts), characters * lost(arrivals.frames, arrivals.counts)
    player.transport.abort()
    return Sent(frames, gone, lasted, theirs / lasted, own / lasted, player.received)


def ask_for_all(endpoint: Endpoint, characters: int, form: str, seconds: float) -> Sent:
    """One batch after the other."""
    bodies = [Crowd.of(characters, seed).body() for seed in range(BODIES)]
    some = [post(f"/v1/poses?format=msgpack&encoding={form}", MEDIA_TYPE, body) for body in bodies]
    asked = ask(endpoint, some, 1, seconds)
    count = len(asked.latencies)
    return Sent(count * characters, 0, asked.seconds, asked.cpu, asked.client_cpu, round(count * asked.body))


def take_stream(endpoint: Endpoint, form: str, seconds: float) -> Sent:
    """One character, as fast as it goes: splices at many frames per second, one after the other."""
    locomotion, action, *_ = clip_names()
    query = f"locomotion={locomotion}&action={action}&rate={FASTEST:g}&encoding={form}"
    request = f"GET /v1/stream?{query} HTTP/1.1\r\nhost: 127.0.0.1\r\nconnection: close\r\n\r\n".encode()
    frames = taken = 0
    began, own, theirs = perf_counter(), process_time(), endpoint.cpu_seconds
    while perf_counter() - began < seconds:
        with socket.create_connection(("127.0.0.1", endpoint.port)) as peer:
            peer.sendall(request)
            while data := peer.recv(RECEIVED):
                taken += len(data)
        frames += int(BANK.seconds * FASTEST) + 1
    lasted, own, theirs = perf_counter() - began, process_time() - own, endpoint.cpu_seconds - theirs
    return Sent(frames, 0, lasted, theirs / lasted, own / lasted, taken)


def _row(name: str, runs: list[Sent]) -> list[str]:
    """Medians over runs; of what is lost, all."""
    per_core = median(one.per_core for one in runs)
    return [
        name,
        f"{median(one.frames / one.seconds for one in runs):,.0f}",
        f"{per_core:,.0f}",
        f"{1e9 / per_core:,.0f}",
        percent(median(one.cpu for one in runs)),
        percent(median(one.client_cpu for one in runs)),
        f"{median(one.bytes / one.frames for one in runs):.1f}",
        f"{median(one.bytes / one.seconds for one in runs) / 1e6:,.0f}",
        f"{sum(one.lost for one in runs):,}",
    ]
