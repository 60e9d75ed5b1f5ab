"""Rates and latencies of HTTP requests, for single poses and for batches."""

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
    """Measures single poses on 32 connections, in turns with a control that answers with as many bytes."""
    locomotions, actions = names(bank, "locomotion"), names(bank, "action")
    findings = Findings(f"One pose per request, {CONNECTIONS} connections, {rounds} rounds of {seconds:g} s")
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
        findings.add(f"{name}: requests per second and core", float(np.median(rates[name])), "{:,.0f}")
        findings.add(f"{name}: latency p99, ms", float(np.median(waits[name])))
    rate, wait = (float(np.median(np.array(found["msgpack"]) / found["control"])) for found in (rates, waits))
    findings.add("msgpack: requests per second and core / the control's", rate, least=0.9)
    findings.add("msgpack: latency p99 / the control's", wait, most=1.2)
    return findings


def batches(bank: Path, *, seconds: float = 4.0, rounds: int = 3) -> Findings:
    """Measures batches of 1,000 characters on one connection.

    The server's time is compared with evaluation and encoding alone, and with a control that only sends as many bytes,
    in turns.
    """
    clips, columns = batch(bank)
    findings = Findings(f"{BATCH} poses per request, {rounds} rounds of {seconds:g} s")
    with serving(bank, "--max-load", "1000000000") as server:
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
            findings.add(f"{numbers}: evaluation and encoding, us", float(np.median(alone)), "{:.0f}")
            findings.add(f"{numbers}: sending as many bytes, us", float(np.median(sending)), "{:.0f}")
            findings.add(f"{numbers}: server time, us", float(np.median(spent)), "{:.0f}")
            ratio = float(np.median(np.array(spent) / np.array(alone)))
            findings.add(f"{numbers}: server time / evaluation and encoding", ratio, most=2.0)
            both = float(np.median(np.array(spent) / (np.array(alone) + np.array(sending))))
            findings.add(f"{numbers}: server time / evaluation, encoding and sending", both)
            for at, name in enumerate(("p50", "p99")):
                waited = float(np.median([percentiles(one.latencies)[at] for one in found]))
                findings.add(f"{numbers}: latency {name}, ms", 1e3 * waited)
    return findings


def _size(server: Process, request: bytes) -> int:
    """Returns the number of bytes of the answer to a request."""
    with socket.create_connection(("127.0.0.1", server.port)) as peer:
        peer.sendall(request)
        head = peer.recv(65536).partition(b"\r\n\r\n")[0]
    return next(int(line.split(b":")[1]) for line in head.splitlines() if line.lower().startswith(b"content-length"))


def batch(bank: Path) -> tuple[list[str], dict[str, NDArray[Any]]]:
    """Returns clip names, and columns with the clip numbers and time of each character of a batch."""
    locomotions, actions = names(bank, "locomotion"), names(bank, "action")
    draw = np.random.default_rng(1)
    columns = {
        "locomotion": draw.integers(0, len(locomotions), BATCH).astype("<i4"),
        "action": (len(locomotions) + draw.integers(0, len(actions), BATCH)).astype("<i4"),
        "time": draw.uniform(0.0, 2.0, BATCH),
    }
    return [*locomotions, *actions], columns


def batch_request(bank: Path, numbers: str) -> bytes:
    """Returns the HTTP request for a batch."""
    clips, columns = batch(bank)
    message = {"clips": clips} | {name: column.tobytes() for name, column in columns.items()}
    return post(f"/v1/poses?format=msgpack&encoding={numbers}", message)


def _alone(bank: Path, clips: list[str], columns: dict[str, NDArray[Any]], numbers: str) -> float:
    """Returns the median microseconds to evaluate and encode a batch."""
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
        packed(opened.digest, {}, how.arrays(evaluator, poses))
        spent.append(time.perf_counter() - began)
    return 1e6 * float(np.median(spent))


def queries(locomotions: list[str], actions: list[str], form: str) -> list[bytes]:
    """Returns 500 requests for single poses at random times, in the format `form`."""
    draw = np.random.default_rng(0)
    return [
        get(
            f"/v1/pose?locomotion={locomotions[number % len(locomotions)]}&time={draw.uniform(0.0, 2.0):.4f}"
            f"&action={actions[number % len(actions)]}&format={form}"
        )
        for number in range(500)
    ]
