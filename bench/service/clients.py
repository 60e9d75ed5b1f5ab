"""Running clients beside the server, and what they saw."""

from __future__ import annotations

import base64
import json
import subprocess
import sys
import time
from dataclasses import asdict, dataclass, replace
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from bench.service import request_client, stream_client
from bench.service.process import Process

STARTING, ENDING = 4.0, 0.5  # seconds that clients have to start in and to make characters; and to stay longer


@dataclass(frozen=True)
class Taken:
    """What one client of a stream got: when each message came, and the number of its first frame."""

    arrivals: list[float]
    numbers: list[int]
    events: list[dict[str, Any]]
    kept: list[bytes]
    bytes: int
    lost: bool


@dataclass(frozen=True)
class Asked:
    """Seconds that each answer took, the server's and the client's processor time, and answers that were errors."""

    latencies: NDArray[np.float64]
    server: float
    client: float
    failed: int


class Streams:
    """Clients of streams, running."""

    def __init__(self, job: stream_client.Job) -> None:
        command = [sys.executable, "-m", "bench.service.stream_client"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(asdict(job)))
        self._process.stdin.close()

    def taken(self) -> list[Taken]:
        """What they got, once they are done."""
        assert self._process.stdout is not None
        told = json.loads(self._process.stdout.read())
        self._process.wait()
        return [
            Taken(
                one["arrivals"],
                one["numbers"],
                [json.loads(event) for event in one["events"]],
                [bytes.fromhex(message) for message in one["kept"]],
                one["bytes"],
                one["lost"],
            )
            for one in told
        ]


def taken_meanwhile(server: Process, job: stream_client.Job) -> tuple[list[Taken], float]:
    """What clients got in the job's seconds once all of them were there, and the server's processor time meanwhile."""
    streams = Streams(replace(job, seconds=STARTING + job.seconds + ENDING))
    time.sleep(STARTING)
    began, spent = time.perf_counter(), server.cpu()
    time.sleep(job.seconds)
    ended, spent = time.perf_counter(), server.cpu() - spent
    return [between(one, began, ended) for one in streams.taken()], spent


def between(taken: Taken, began: float, ended: float) -> Taken:
    """What came from one moment to another, of the clock that all processes have."""
    some = [(at, number) for at, number in zip(taken.arrivals, taken.numbers, strict=True) if began <= at < ended]
    size = taken.bytes / max(1, len(taken.arrivals))
    return replace(
        taken,
        arrivals=[at for at, _ in some],
        numbers=[number for _, number in some],
        bytes=round(size * len(some)),
    )


def ask(server: Process, requests: list[bytes], connections: int, seconds: float) -> Asked:
    """Has clients ask for some time."""
    packed = [base64.b64encode(one).decode() for one in requests]
    job = request_client.Job(server.port, packed, connections, seconds)
    command, before = [sys.executable, "-m", "bench.service.request_client"], server.cpu()
    done = subprocess.run(command, input=json.dumps(asdict(job)), capture_output=True, text=True, check=True)
    told = json.loads(done.stdout)
    return Asked(np.array(told["latencies"]), server.cpu() - before, told["cpu"], told["failed"])


def get(path: str) -> bytes:
    return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode()


def post(path: str, message: dict[str, Any]) -> bytes:
    """A request with MessagePack as its body."""
    body: bytes = msgpack.packb(message)
    head = (
        f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/msgpack\r\nContent-Length: {len(body)}"
    )
    return f"{head}\r\n\r\n".encode() + body


def create(characters: int, locomotions: list[str], actions: list[str]) -> list[str]:
    """Commands that make characters, all of them doing something else, in messages that are short enough."""
    messages = []
    for first in range(0, characters, 400):
        told: list[dict[str, Any]] = []
        for one in range(first, min(first + 400, characters)):
            told += [
                {"do": "create", "id": one, "locomotion": locomotions[one % len(locomotions)], "time": one % 7 / 4},
                {"do": "act", "id": one, "action": actions[one % len(actions)]},
            ]
        messages.append(json.dumps(told))
    return messages
