"""Requests per second and what they wait: one pose, and a batch of them."""

from __future__ import annotations

import socket
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.findings import Findings
from bench.service.banks import names
from bench.service.clients import ask, get, post
from bench.service.process import Process, control, serving
from bench.service.statistics import percentiles
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import METHODS, Requests
from motionsplice.service.wire.encoding import Encoding, warm
from motionsplice.service.wire.messages import packed

CONNECTIONS = 32
BATCH = 1000


def poses(bank: Path, *, seconds: float = 5.0, rounds: int = 3) -> Findings:
    """Single poses at 32 connections, in turns with a server that answers as many bytes and does nothing."""
    locomotions, actions = names(bank, "locomotion"), names(bank, "action")
    told = Findings(f"One pose a request, {CONNECTIONS} connections, {rounds} times {seconds:g} s")
    rates: dict[str, list[float]] = {"msgpack": [], "json": [], "control": []}
    waits: dict[str, list[float]] = {"msgpack": [], "json": [], "control": []}
    with serving(bank) as server:
        asked = {form: queries(locomotions, actions, form) for form in ("msgpack", "json")}
        with control("450", "1") as other:
            for _ in range(rounds):
                for name in rates:
                    one, requests = (other, [get("/")]) if name == "control" else (server, asked[name])
                    found = ask(one, requests, CONNECTIONS, seconds)
                    assert not found.failed
                    rates[name].append(len(found.latencies) / found.server)
                    waits[name].append(1e3 * percentiles(found.latencies)[1])
    for name in rates:
        most, least = (3.0, 15_000) if name == "msgpack" else (None, None)
        told.add(f"{name}: requests per second and core", float(np.median(rates[name])), "{:,.0f}", least=least)
        told.add(f"{name}: latency p99, ms", float(np.median(waits[name])), most=most)
    return told


def batches(bank: Path, *, seconds: float = 4.0, rounds: int = 3) -> Findings:
    """Batches of 1,000 characters on one connection: the server's time against evaluation and encoding alone, and
    against a server that does nothing but send as many bytes; in turns."""
    clips, columns = batch(bank)
    told = Findings(f"{BATCH} poses a request, {rounds} times {seconds:g} s")
    with serving(bank) as server:
        for numbers in ("float32", "int16"):
            request, found = batch_request(bank, numbers), []
            alone, spent, sending = [], [], []
            with control(str(_size(server, request)), "1") as other:
                for _ in range(rounds):
                    alone.append(_alone(bank, clips, columns, numbers))
                    found.append(ask(server, [request], 1, seconds))
                    sent = ask(other, [get("/")], 1, seconds)
                    assert not found[-1].failed
                    spent.append(1e6 * found[-1].server / len(found[-1].latencies))
                    sending.append(1e6 * sent.server / len(sent.latencies))
            told.add(f"{numbers}: evaluation and encoding alone, us", float(np.median(alone)), "{:.0f}")
            told.add(f"{numbers}: sending as many bytes alone, us", float(np.median(sending)), "{:.0f}")
            told.add(f"{numbers}: the server's time, us", float(np.median(spent)), "{:.0f}")
            ratio = float(np.median(np.array(spent) / np.array(alone)))
            told.add(f"{numbers}: times evaluation and encoding", ratio, most=2.0)
            both = float(np.median(np.array(spent) / (np.array(alone) + np.array(sending))))
            told.add(f"{numbers}: times evaluation, encoding and sending", both)
            for at, name in enumerate(("p50", "p99")):
                waited = float(np.median([percentiles(one.latencies)[at] for one in found]))
                told.add(f"{numbers}: latency {name}, ms", 1e3 * waited)
    return told


def _size(server: Process, request: bytes) -> int:
    """Bytes of the answer to a request."""
    with socket.create_connection(("127.0.0.1", server.port)) as peer:
        peer.sendall(request)
        head = peer.recv(65536).partition(b"\r\n\r\n")[0]
    return next(int(line.split(b":")[1]) for line in head.splitlines() if line.lower().startswith(b"content-length"))


def batch(bank: Path) -> tuple[list[str], dict[str, NDArray[Any]]]:
    """Clips, and what each character of a batch plays of them."""
    locomotions, actions = names(bank, "locomotion"), names(bank, "action")
    draw = np.random.default_rng(1)
    columns = {
        "locomotion": draw.integers(0, len(locomotions), BATCH).astype("<i4"),
        "action": (len(locomotions) + draw.integers(0, len(actions), BATCH)).astype("<i4"),
        "time": draw.uniform(0.0, 2.0, BATCH),
    }
    return [*locomotions, *actions], columns


def batch_request(bank: Path, numbers: str) -> bytes:
    """The request for a batch."""
    clips, columns = batch(bank)
    message = {"clips": clips} | {name: column.tobytes() for name, column in columns.items()}
    return post(f"/v1/poses?format=msgpack&encoding={numbers}", message)


def _alone(bank: Path, clips: list[str], columns: dict[str, NDArray[Any]], numbers: str) -> float:
    """Microseconds to evaluate and encode a batch, median."""
    opened = Bank.open(bank)
    evaluator, how, requests = Evaluator(opened), Encoding(numbers=numbers), Requests.empty(BATCH)
    index = np.array([opened.number(name) for name in clips])
    requests.locomotion[:], requests.action[:] = index[columns["locomotion"]], index[columns["action"]]
    requests.time[:], requests.method[:] = columns["time"], METHODS["splice"]
    warm()
    spent = []
    for _ in range(300):
        began = time.perf_counter()
        poses = evaluator.poses(BATCH)
        evaluator.evaluate(requests, poses)
        packed({"bank": opened.digest}, how.arrays(evaluator, poses))
        spent.append(time.perf_counter() - began)
    return 1e6 * float(np.median(spent))


def queries(locomotions: list[str], actions: list[str], form: str) -> list[bytes]:
    draw = np.random.default_rng(0)
    return [
        get(
            f"/v1/pose?locomotion={locomotions[number % len(locomotions)]}&time={draw.uniform(0.0, 2.0):.4f}"
            f"&action={actions[number % len(actions)]}&format={form}"
        )
        for number in range(500)
    ]
