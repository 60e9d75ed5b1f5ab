"""Takes all descriptors of the service, exchanges the bank meanwhile, and gives them back."""

from __future__ import annotations

import resource
import socket
import time
from contextlib import suppress
from pathlib import Path

from bench.findings import Findings
from bench.service.banks import another, names, put
from bench.service.clients import Streams, create
from bench.service.process import Process, serving
from bench.service.statistics import lost
from bench.service.stream_client import Job
from bench.service.streams import PATH
from motionsplice.runtime.bank import Bank

STREAMS = 8
ROOM = 40  # descriptors that the service may have beside those at the start
PATIENCE = 30.0  # seconds in which it must serve the new bank once it has descriptors again


def descriptors(bank: Path, *, seconds: float = 10.0) -> Findings:
    """Measures the service while clients hold all the descriptors that it may have, and after they have left."""
    new = another(bank.parent)
    commands = create(1, names(bank, "locomotion"), names(bank, "action"))
    with serving(bank, "--watch") as server:
        streams = Streams(Job(server.port, PATH, STREAMS, seconds + PATIENCE / 2.0, commands))
        time.sleep(2.0)
        begun = server.descriptors()
        _limit(server, begun + ROOM)
        peers = [_peer(server) for _ in range(2 * ROOM)]
        time.sleep(1.0)
        before, taken = server.cpu(), server.descriptors()
        put(new, bank)
        time.sleep(seconds)
        busy = (server.cpu() - before) / seconds
        for peer in peers:
            peer.close()
        wanted, left = Bank.open(new).digest, time.monotonic()
        while _served(server) != wanted and time.monotonic() < left + PATIENCE:
            time.sleep(0.1)
        later, served = time.monotonic() - left, _served(server)
        clients = streams.taken()
        time.sleep(1.0)
        rest = server.descriptors()
    findings = Findings(f"{2 * ROOM} more connections than {ROOM} descriptors, beside {STREAMS} streams")
    findings.add("descriptors taken", taken - begun, "{:.0f}", least=ROOM - 1)
    findings.add("processor meanwhile", busy, most=0.5)
    findings.add("streams dropped", sum(one.lost for one in clients), "{:.0f}", most=0)
    findings.add("frames skipped, which a busy machine causes too", sum(lost(one.numbers) for one in clients), "{:.0f}")
    findings.add("new bank served", served == wanted, "{:.0f}", least=1)
    findings.add("seconds until then", later, "{:.1f}", most=PATIENCE)
    findings.add("descriptors left over", rest + STREAMS - begun, "{:.0f}", most=0)
    return findings


def _limit(server: Process, most: int) -> None:
    resource.prlimit(server.pid, resource.RLIMIT_NOFILE, (most, most))


def _peer(server: Process) -> socket.socket:
    peer = socket.socket()
    peer.settimeout(1.0)
    with suppress(OSError):  # the service cannot take it
        peer.connect(("127.0.0.1", server.port))
    return peer


def _served(server: Process) -> str:
    with suppress(OSError):
        found = server.get("/v1/server")
        return str(found["bank"])
    return ""
