"""Whether a client can hurt another: clients that read nothing, and clients that come and go in the middle."""

from __future__ import annotations

import socket
import time
from pathlib import Path

import numpy as np

from bench.findings import Findings
from bench.service.banks import names
from bench.service.clients import Streams, create
from bench.service.process import Process, serving
from bench.service.stream_client import HANDSHAKE, Job
from bench.service.streams import PATH, spread

HEALTHY = 20
STALLED = 20
SKIP = 60  # frames while clients start, which takes a processor
CREATE = b'{"do": "create", "id": 1, "locomotion": "walk"}'


def stalled(bank: Path, *, seconds: float = 20.0, rounds: int = 2) -> Findings:
    """20 clients alone, in turns with 20 beside 20 that stop reading half a second after they came."""
    commands = create(1, names(bank, "locomotion"), names(bank, "action"))
    told = Findings(f"{HEALTHY} clients beside {STALLED} that read nothing, {rounds} times {seconds:g} s")
    alone, beside, freed, memory = [], [], [], []
    with serving(bank) as server:
        for _ in range(rounds):
            alone.append(spread(Streams(Job(server.port, PATH, HEALTHY, seconds, commands)).taken(), skip=SKIP)[1])
            time.sleep(1.0)
            memory.append(server.memory())
            before = server.descriptors()
            bad = Streams(Job(server.port, PATH, STALLED, seconds, commands, stalled=STALLED))
            healthy = Streams(Job(server.port, PATH, HEALTHY, seconds, commands))
            freed.append(_freed(server, before, seconds))
            beside.append(spread(healthy.taken(), skip=SKIP)[1])
            bad.taken()
            time.sleep(1.0)
        memory.append(server.memory())
    told.add("the last of the stalled is freed after, s", max(freed), "{:.1f}", most=10.0)
    told.add("jitter p99 of the healthy alone, ms", float(np.median(alone)))
    told.add("jitter p99 beside the stalled, ms", float(np.median(beside)))
    ratio = float(np.median(np.array(beside) / np.array(alone)))
    told.add("times that alone (median of rounds)", ratio, most=1.1)
    told.add("memory grown, MB", memory[-1] - memory[0], "{:.1f}", most=5.0)
    return told


def _freed(server: Process, before: int, seconds: float) -> float:
    """Seconds from when all are there until the stalled are gone; the system says it, without a word to the server."""
    deadline = time.monotonic() + seconds
    while server.descriptors() < before + HEALTHY + STALLED and time.monotonic() < deadline:
        time.sleep(0.05)
    began = time.monotonic()
    while server.descriptors() > before + HEALTHY and time.monotonic() < deadline:
        time.sleep(0.1)
    return time.monotonic() - began


def connects(bank: Path, *, times: int = 1000) -> Findings:
    """Connections that are cut at any stage leave nothing behind."""
    told = Findings(f"{times} connects and aborts")
    handshake = HANDSHAKE.format(path=PATH).encode()
    text = bytes((0x81, 0x80 | len(CREATE))) + bytes(4) + CREATE
    stages = (
        b"",
        b"GET /v1/pose HTTP/1.1\r\nHo",
        b"POST /v1/poses HTTP/1.1\r\nContent-Type: application/msgpack\r\nContent-Length: 99\r\n\r\nx",
        b"GET /v1/stream?locomotion=walk&pace=realtime HTTP/1.1\r\nHost: x\r\n\r\n",
        handshake,
        handshake + text,
        handshake + text + text[:9],
    )
    with serving(bank) as server:
        _cut(server, stages, 50)  # what is made once is made
        descriptors, memory = _at_rest(server), server.memory()
        _cut(server, stages, times)
        told.add("descriptors more than before", _at_rest(server) - descriptors, "{:.0f}", most=0)
        told.add("memory grown, MB", server.memory() - memory, "{:.1f}", most=5.0)
        for kind, left in _left(server).items():
            told.add(f"connections left, {kind}", left, "{:.0f}", most=0)
    return told


def _cut(server: Process, stages: tuple[bytes, ...], times: int) -> None:
    for number in range(times):
        with socket.create_connection(("127.0.0.1", server.port)) as peer:
            peer.sendall(stages[number % len(stages)])
            if number % 3 == 0:
                time.sleep(0.002)
            if number % 2:  # a reset instead of an end
                peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\x00\x00\x00\x00\x00\x00\x00")
    deadline = time.monotonic() + 20.0
    while any(_left(server).values()) and time.monotonic() < deadline:
        time.sleep(0.1)


def _at_rest(server: Process) -> int:
    """Descriptors that are left when the connection that asked for metrics is closed too."""
    counts = []
    for _ in range(10):
        time.sleep(0.1)
        counts.append(server.descriptors())
    return min(counts)


def _left(server: Process) -> dict[str, float]:
    """Connections that the server counts, but for the one that asks for them."""
    kinds = ("http", "stream", "characters")
    return {kind: server.metric(f'motionsplice_connections{{kind="{kind}"}}') - (kind == "http") for kind in kinds}
