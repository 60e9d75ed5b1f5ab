"""Measures the harm that floods do to healthy clients: long lists of commands, pings, and big batches.

Flooders are on other machines as a rule. Here they share the processor with the service and the healthy clients, which
therefore run before them, and before all else on the machine, if the system permits it.
"""

from __future__ import annotations

import base64
import json
import math
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.findings import Findings
from bench.service import flood_client, request_client
from bench.service.banks import names
from bench.service.clients import Streams, Taken, create, post, post_body, started
from bench.service.harm import HEALTHY
from bench.service.process import Process, prefer, serving
from bench.service.statistics import percentiles
from bench.service.stream_client import PING, TEXT, Job, frame
from bench.service.streams import PATH, RATE

SETTLING = 2.0  # seconds for clients to start
SPARE = 30.0  # seconds by which clients would stay longer than they are needed
FLOODERS, PINGING, ASKING = 8, 4, 4
TICKS = "motionsplice_tick_lateness_seconds"
IN_TIME = "0.002"  # seconds, a bound of the service's histogram
LONGEST = 65_500  # bytes of a message
CHARACTERS = 10_000  # in a batch of blobs
NUMBERS = 8_000  # characters in a batch of JSON, which must be smaller
POSES = "/v1/poses?encoding=int16&format=msgpack"
CREATE = '{"do":"create","id":1,"locomotion":"%s"}'

Flood = Callable[[Process, float], AbstractContextManager[object]]


def floods(bank: Path, *, seconds: float = 6.0, rounds: int = 3) -> Findings:
    """Measures 20 clients alone, in turns with the same beside each flood."""
    commands = create(1, names(bank, "locomotion"), names(bank, "action"))
    lasting = 2.0 * SETTLING + seconds + SPARE
    every: dict[str, Flood] = {"calm": lambda server, seconds: nullcontext(), **_floods(bank)}
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in every}
    frames: dict[str, list[float]] = {name: [] for name in every}
    ticks: dict[str, list[NDArray[np.float64]]] = {name: [] for name in every}
    with serving(bank) as server:
        priority = "at real-time priority" if prefer(server.pid) else "without priority"
        for _ in range(rounds):
            for name, flood in every.items():
                healthy = Streams(Job(server.port, PATH, HEALTHY, lasting, commands))
                healthy.prefer()
                time.sleep(SETTLING)
                with flood(server, lasting):
                    time.sleep(SETTLING)
                    before, began = _ticks(server), time.perf_counter()
                    time.sleep(seconds)
                    ended, after = time.perf_counter(), _ticks(server)
                healthy.end()
                late = _lateness(healthy.taken(), began, ended)
                found[name].append(percentiles(late))
                frames[name].append(float(np.mean(late < 1e3 / RATE)))
                ticks[name].append(after - before)
    findings = Findings(f"{HEALTHY} healthy clients {priority} beside floods, {rounds} rounds of {seconds:g} s")
    calm = np.array(found["calm"])
    for name in every:
        p50, p99 = np.median(found[name], axis=0)
        findings.add(f"{name}: lateness of frames, p50, ms", float(p50))
        findings.add(f"{name}: lateness of frames, p99, ms", float(p99))
        if name != "calm":
            ratio = float(np.median(np.array(found[name])[:, 1] / calm[:, 1]))
            findings.add(f"{name}: p99 / calm (median of rounds)", ratio, most=1.5)
        findings.add(f"{name}: share of frames that arrive before the next is due", float(np.median(frames[name])))
        whole, in_time = np.sum(ticks[name], axis=0)
        findings.add(f"{name}: share of the service's ticks later than {IN_TIME} s", 1.0 - in_time / whole, "{:.3f}")
    return findings


def _ticks(server: Process) -> NDArray[np.float64]:
    """Returns how often the service has begun to make frames, and how often of these in time."""
    return np.array(server.metrics(f"{TICKS}_count", f'{TICKS}_bucket{{le="{IN_TIME}"}}'))


def _lateness(taken: list[Taken], began: float, ended: float) -> NDArray[np.float64]:
    """Returns how late each frame that is due between two moments arrives, or a newer one, in milliseconds.

    A frame is due as long after the client's most punctual one as its number says.
    """
    every = []
    for one in taken:
        arrivals, numbers = np.array([*one.arrivals, ended]), np.array(one.numbers)
        first = (arrivals[:-1] - numbers / RATE).min()
        due = np.arange(math.ceil((began - first) * RATE), (ended - first) * RATE)
        every.append(1e3 * (arrivals[np.searchsorted(numbers, due)] - first - due / RATE))
    return np.concatenate(every)


def _floods(bank: Path) -> dict[str, Flood]:
    locomotion, action = names(bank, "locomotion")[0], names(bank, "action")[0]
    act = json.dumps({"do": "act", "id": 1, "action": action}, separators=(",", ":"))
    acts = [act] * ((LONGEST - 2) // (len(act) + 1))
    wrong = [*acts[:-1], act.replace("act", "atc", 1)]
    first = frame(TEXT, (CREATE % locomotion).encode())
    pings = 1000 * frame(PING, b"")
    return {
        f"{FLOODERS} clients of {len(acts)} commands a message": _pouring(FLOODERS, first, _listed(acts)),
        f"{FLOODERS} clients of {len(acts)} commands a message, refused": _pouring(FLOODERS, first, _listed(wrong)),
        f"{PINGING} clients of pings": _pouring(PINGING, first, pings),
        f"{ASKING} clients of batches of {CHARACTERS}": _asking(_blobs(locomotion, action)),
        f"{ASKING} clients of batches of {NUMBERS}, JSON": _asking(_numbers(locomotion)),
    }


def _listed(commands: list[str]) -> bytes:
    return frame(TEXT, f"[{','.join(commands)}]".encode())


def _blobs(locomotion: str, action: str) -> bytes:
    columns = {"locomotion": np.zeros(CHARACTERS, "<i4"), "action": np.ones(CHARACTERS, "<i4")}
    times = {"time": np.arange(CHARACTERS) / CHARACTERS}
    blobs = {key: column.tobytes() for key, column in {**columns, **times}.items()}
    return post(POSES, {"clips": [locomotion, action], **blobs})


def _numbers(locomotion: str) -> bytes:
    times = [round(number / NUMBERS, 4) for number in range(NUMBERS)]
    body = {"clips": [locomotion], "locomotion": [0] * NUMBERS, "time": times, "start": times}
    return post_body(POSES, "application/json", json.dumps(body, separators=(",", ":")).encode())


def _pouring(connections: int, first: bytes, flood: bytes) -> Flood:
    def begin(server: Process, seconds: float) -> AbstractContextManager[object]:
        texts = [base64.b64encode(one).decode() for one in (first, flood)]
        return _running("flood_client", flood_client.Job(server.port, PATH, connections, seconds, *texts))

    return begin


def _asking(request: bytes) -> Flood:
    def begin(server: Process, seconds: float) -> AbstractContextManager[object]:
        job = request_client.Job(server.port, [base64.b64encode(request).decode()], ASKING, seconds)
        return _running("request_client", job)

    return begin


@contextmanager
def _running(client: str, job: flood_client.Job | request_client.Job) -> Iterator[None]:
    with started(client, job, "nice") as process:
        yield
        process.kill()
