"""Starts clients in separate processes, and collects what they received."""

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
from bench.service.process import Process, prefer

STARTING, ENDING = 4.0, 0.5  # seconds for clients to start and create characters, and to stay after the measurement


@dataclass(frozen=True)
class Taken:
    """The record of one client of a stream: the arrival time of each message, and the number of its first frame."""

    arrivals: list[float]
    numbers: list[int]
    events: list[dict[str, Any]]
    kept: list[bytes]
    bytes: int
    lost: bool


@dataclass(frozen=True)
class Asked:
    """Seconds of each answer, processor seconds of the server and the client, and the number of error answers."""

    latencies: NDArray[np.float64]
    server: float
    client: float
    failed: int


def started(client: str, job: stream_client.Connections | request_client.Job, *before: str) -> subprocess.Popen[str]:
    """Starts one of the client modules with its job. before: what its command begins with, such as `nice`."""
    command = [*before, sys.executable, "-m", f"bench.service.{client}"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdin is not None
    process.stdin.write(json.dumps(asdict(job)))
    process.stdin.close()
    return process


class Streams:
    """Running clients of streams."""

    def __init__(self, job: stream_client.Job) -> None:
        self._process = started("stream_client", job)

    def prefer(self) -> None:
        """Lets the clients run before other processes, if the system permits it."""
        prefer(self._process.pid)

    def end(self) -> None:
        """Ends the clients before their time is over."""
        self._process.terminate()

    def taken(self) -> list[Taken]:
        """Waits until the clients are done, and returns what each received."""
        assert self._process.stdout is not None
        clients = json.loads(self._process.stdout.read())
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
            for one in clients
        ]


def taken_meanwhile(server: Process, job: stream_client.Job, starting: float = STARTING) -> tuple[list[Taken], float]:
    """Returns what clients received in `job.seconds` after all had started, and the server's processor seconds."""
    streams = Streams(replace(job, seconds=starting + job.seconds + ENDING))
    time.sleep(starting)
    began, spent = time.perf_counter(), server.cpu()
    time.sleep(job.seconds)
    ended, spent = time.perf_counter(), server.cpu() - spent
    return [between(one, began, ended) for one in streams.taken()], spent


def between(taken: Taken, began: float, ended: float) -> Taken:
    """Returns the messages that arrived between two times of the clock that all processes share."""
    some = [(at, number) for at, number in zip(taken.arrivals, taken.numbers, strict=True) if began <= at < ended]
    size = taken.bytes / max(1, len(taken.arrivals))
    return replace(
        taken,
        arrivals=[at for at, _ in some],
        numbers=[number for _, number in some],
        bytes=round(size * len(some)),
    )


def ask(server: Process, requests: list[bytes], connections: int, seconds: float) -> Asked:
    """Lets clients send requests over and over for `seconds`."""
    packed = [base64.b64encode(one).decode() for one in requests]
    job = request_client.Job(server.port, packed, connections, seconds)
    command, before = [sys.executable, "-m", "bench.service.request_client"], server.cpu()
    done = subprocess.run(command, input=json.dumps(asdict(job)), capture_output=True, text=True, check=True)
    result = json.loads(done.stdout)
    return Asked(np.array(result["latencies"]), server.cpu() - before, result["cpu"], result["failed"])


def get(path: str) -> bytes:
    """Returns a GET request."""
    return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode()


def post(path: str, message: dict[str, Any]) -> bytes:
    """Returns a POST request with a MessagePack body."""
    return post_body(path, "application/msgpack", msgpack.packb(message))


def post_body(path: str, media_type: str, body: bytes) -> bytes:
    """Returns a POST request."""
    head = f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: {media_type}\r\nContent-Length: {len(body)}"
    return f"{head}\r\n\r\n".encode() + body


def create(characters: int, locomotions: list[str], actions: list[str]) -> list[str]:
    """Returns messages of commands that create characters with different clips, in messages below the size limit."""
    messages = []
    for first in range(0, characters, 400):
        commands: list[dict[str, Any]] = []
        for one in range(first, min(first + 400, characters)):
            commands += [
                {"do": "create", "id": one, "locomotion": locomotions[one % len(locomotions)], "time": one % 7 / 4},
                {"do": "act", "id": one, "action": actions[one % len(actions)]},
            ]
        messages.append(json.dumps(commands))
    return messages
