"""Measures whether clients can harm others: by not reading, or by aborting connections at any stage."""

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
SKIP = 60  # frames to ignore at the start, when starting clients use the processor
MOST_GROWN = 8.0  # MB; memory stops growing at 6.5 MB after 32,000 aborted connections
CREATE = b'{"do": "create", "id": 1, "locomotion": "walk"}'


def stalled(bank: Path, *, seconds: float = 20.0, rounds: int = 2) -> Findings:
    """Measures 20 clients alone, in turns with 20 beside another 20 that stop reading 0.5 s after connecting."""
    commands = create(1, names(bank, "locomotion"), names(bank, "action"))
    findings = Findings(f"{HEALTHY} healthy clients beside {STALLED} stalled ones, {rounds} rounds of {seconds:g} s")
    alone, beside, closed, memory = [], [], [], []
    with serving(bank) as server:
        for _ in range(rounds):
            alone.append(spread(Streams(Job(server.port, PATH, HEALTHY, seconds, commands)).taken(), skip=SKIP)[1])
            time.sleep(1.0)
            memory.append(server.memory())
            before = server.descriptors()
            bad = Streams(Job(server.port, PATH, STALLED, seconds, commands, stalled=STALLED))
            healthy = Streams(Job(server.port, PATH, HEALTHY, seconds, commands))
            closed.append(_seconds_until_closed(server, before, seconds))
            beside.append(spread(healthy.taken(), skip=SKIP)[1])
            bad.taken()
            time.sleep(1.0)
        memory.append(server.memory())
    findings.add("last stalled client closed after, s", max(closed), "{:.1f}", most=10.0)
    findings.add("jitter p99 of healthy clients alone, ms", float(np.median(alone)))
    findings.add("jitter p99 beside stalled clients, ms", float(np.median(beside)))
    ratio = float(np.median(np.array(beside) / np.array(alone)))
    findings.add("jitter p99 beside stalled / alone (median of rounds)", ratio, most=1.1)
    findings.add("growth of memory, MB", memory[-1] - memory[0], "{:.1f}", most=5.0)
    return findings


def _seconds_until_closed(server: Process, before: int, seconds: float) -> float:
    """Returns the seconds from when all clients are connected until the stalled ones are closed.

    Counts descriptors of the process, so that the server is not disturbed by requests.
    """
    deadline = time.monotonic() + seconds
    while server.descriptors() < before + HEALTHY + STALLED and time.monotonic() < deadline:
        time.sleep(0.05)
    began = time.monotonic()
    while server.descriptors() > before + HEALTHY and time.monotonic() < deadline:
        time.sleep(0.1)
    return time.monotonic() - began


def connects(bank: Path, *, times: int = 1000) -> Findings:
    """Measures what is left of connections that are aborted at any stage."""
    findings = Findings(f"{times} aborted connections")
    handshake = HANDSHAKE.format(path=PATH).encode()
    text = bytes((0x81, 0x80 | len(CREATE))) + bytes(4) + CREATE
    stages = (
        b"",
        b"GET /v1/pose HTTP/1.1\r\nHo",
        b"POST /v1/poses HTTP/1.1\r\nContent-Type: application/msgpack\r\nContent-Length: 99\r\n\r\nx",
        b"GET /v1/stream?locomotion=walk&pace=realtime HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
        handshake,
        handshake + text,
        handshake + text + text[:9],
    )
    with serving(bank) as server:
        _cut(server, stages, 50)  # lets the server allocate what it allocates once
        descriptors, memory = _settled_descriptors(server), server.memory()
        _cut(server, stages, times)
        findings.add("additional descriptors", _settled_descriptors(server) - descriptors, "{:.0f}", most=0)
        findings.add("growth of memory, MB", server.memory() - memory, "{:.1f}", most=MOST_GROWN)
        for kind, left in _left(server).items():
            findings.add(f"connections left, {kind}", left, "{:.0f}", most=0)
    return findings


def _cut(server: Process, stages: tuple[bytes, ...], times: int) -> None:
    """Opens connections, sends each of `stages` in turn, and aborts; then waits until the server has none left."""
    for number in range(times):
        with socket.create_connection(("127.0.0.1", server.port)) as peer:
            peer.sendall(stages[number % len(stages)])
            if number % 3 == 0:
                time.sleep(0.002)
            if number % 2:  # ends with a reset instead of an orderly close
                peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\x00\x00\x00\x00\x00\x00\x00")
    deadline = time.monotonic() + 20.0
    while any(_left(server).values()) and time.monotonic() < deadline:
        time.sleep(0.1)


def _settled_descriptors(server: Process) -> int:
    """Returns the open descriptors after the connection that asked for metrics is closed too."""
    counts = []
    for _ in range(10):
        time.sleep(0.1)
        counts.append(server.descriptors())
    return min(counts)


def _left(server: Process) -> dict[str, float]:
    """Returns the connections that the server counts, by kind, without the one that asks for the metric."""
    kinds = ("http", "stream", "characters")
    return {kind: server.metric(f'motionsplice_connections{{kind="{kind}"}}') - (kind == "http") for kind in kinds}
