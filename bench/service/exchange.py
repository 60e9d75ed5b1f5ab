"""Exchanges banks while streams run."""

from __future__ import annotations

import json
import time
from pathlib import Path

import msgpack
import numpy as np

from bench.findings import Findings
from bench.service.banks import another, put
from bench.service.clients import Streams
from bench.service.process import Process, serving
from bench.service.statistics import lost
from bench.service.stream_client import Job
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

STREAMS = 32
EXCHANGES = 20
PATH = "/v1/characters?rate=60"
WARM = 20  # exchanges, after which memory must not grow
PATIENCE = 30.0  # seconds in which a bank must be served or refused
INTERVAL = 0.1  # seconds between two looks whether it is, and until the next bank
LONGEST_PAUSE = 2000  # ms; a busy machine causes 750, and a kernel that must be compiled thousands


def exchange(bank: Path, *, exchanges: int = EXCHANGES) -> Findings:
    """Exchanges the bank repeatedly under 32 streams, each of a character whose clip is paused.

    So each frame must have the pose of the bank that it names. One of the banks is damaged, and must be refused.
    """
    place, other = bank, another(bank.parent)
    first = bank.parent / "first"
    put_aside(bank, first)
    still = [{"do": "create", "id": 1, "locomotion": "run", "time": 1.0}, {"do": "speed", "id": 1, "speed": 0.0}]
    with serving(place, "--watch") as server:
        streams = Streams(Job(server.port, PATH, STREAMS, PATIENCE * exchanges, [json.dumps(still)], keep=2))
        time.sleep(2.0)
        done = 0
        for number in range(exchanges):
            if number == min(WARM, exchanges // 2):  # by then it has allocated what it allocates once
                memory, descriptors = server.memory(), server.descriptors()
            damaged = number == exchanges // 2
            put((other, first)[done % 2], place, damaged=damaged)
            done += not damaged
            _wait(server, "refused" if damaged else "ok", 1 if damaged else done)
        memory, descriptors = server.memory() - memory, server.descriptors() - descriptors
        streams.end()
        taken = streams.taken()
        refused, served = _exchanges(server, "refused"), _exchanges(server, "ok")
        skipped = server.metric("motionsplice_frames_skipped_total")
    expected = {}
    for folder in (first, other):
        opened = Bank.open(folder)
        characters = Characters(Stage(Evaluator(opened)), 60.0)
        characters.add(1, "run", time=1.0)
        poses = characters.stage.evaluator.poses(1)
        characters.evaluate(poses)
        expected[opened.digest] = poses.rotations.tobytes()
    frames = [msgpack.unpackb(message) for one in taken for message in one.kept]
    torn = sum(frame["rotations"] != expected[frame["bank"]] for frame in frames)
    findings = Findings(f"{exchanges} exchanges under {STREAMS} streams at 60 Hz")
    findings.add("banks exchanged", served, "{:.0f}", least=exchanges - 1)
    findings.add("damaged banks refused", refused, "{:.0f}", least=1, most=None)
    findings.add("connections dropped", sum(one.lost for one in taken), "{:.0f}", most=0)
    missing = sum(lost(one.numbers) for one in taken)
    findings.add("frames left out, which a busy machine causes too", skipped, "{:.0f}")
    findings.add("frames lost, which the service does not know of", max(0.0, missing - skipped), "{:.0f}", most=0)
    findings.add("frames checked", len(frames), "{:.0f}", least=STREAMS)
    findings.add("frames with a wrong pose", torn, "{:.0f}", most=0)
    findings.add("different banks in the frames", len({frame["bank"] for frame in frames}), "{:.0f}", least=2)
    findings.add("growth of memory, MB", memory, "{:.1f}", most=20.0)
    findings.add("additional descriptors", descriptors, "{:.0f}", most=0)
    gaps = np.concatenate([np.diff(one.arrivals) for one in taken])
    findings.add("longest pause between two frames, ms", 1e3 * float(gaps.max()), "{:.0f}", most=LONGEST_PAUSE)
    return findings


def _wait(server: Process, result: str, count: int) -> None:
    """Waits until as many exchanges have had a result."""
    deadline = time.monotonic() + PATIENCE
    while _exchanges(server, result) < count and time.monotonic() < deadline:
        time.sleep(INTERVAL)
    time.sleep(INTERVAL)


def _exchanges(server: Process, result: str) -> float:
    return server.metric(f'motionsplice_bank_exchanges_total{{result="{result}"}}')


def put_aside(bank: Path, place: Path) -> None:
    """Copies a bank to `place`."""
    (place / "tables").mkdir(parents=True)
    put(bank, place)
