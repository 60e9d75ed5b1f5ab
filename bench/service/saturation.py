"""Streams until and past the point where one process cannot make all frames that are due."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from bench.findings import Findings
from bench.service.banks import names
from bench.service.clients import STARTING, create, taken_meanwhile
from bench.service.process import serving
from bench.service.stream_client import Job
from bench.service.streams import PATH, RATE

CONNECTIONS = (200, 320, 400, 512, 700, 1000)
CONNECTED = 50  # clients that connect and create their characters in a second, on a busy machine
CROWDS, CROWD = 4, 5000  # streams, and the characters of each
LIMITS = (
    *("--max-load", "1000000000", "--max-streams", "4096"),
    *("--max-connections", "8192", "--max-connections-per-address", "8192"),
)


def saturation(bank: Path, *, seconds: float = 5.0) -> Findings:
    """Measures 200 to 1,000 streams of one character at 60 Hz, and 4 of 5,000 characters.

    One process has one core. So past some number of streams, it must leave frames out: as few as before, and for all
    clients alike. All clients are in another process. On a machine that others use, figures per second of processor
    time say more than those per second.
    """
    clips = names(bank, "locomotion"), names(bank, "action")
    findings = Findings(f"Streams past saturation, {RATE:g} Hz, {seconds:g} s each")
    sent, per_core = [], []
    with serving(bank, *LIMITS) as server:
        for count in CONNECTIONS:
            job = Job(server.port, PATH, count, seconds, create(1, *clips))
            taken, spent = taken_meanwhile(server, job, STARTING + count / CONNECTED)
            frames = np.array([len(one.arrivals) for one in taken])
            sent.append(frames.sum() / seconds)
            per_core.append(frames.sum() / spent)
            worst = frames.min() / max(1.0, float(np.median(frames)))
            findings.add(f"{count} streams: messages per second", sent[-1], "{:,.0f}")
            findings.add(f"{count} streams: messages per second of processor time", per_core[-1], "{:,.0f}", least=3e4)
            findings.add(f"{count} streams: worst client / median", worst, least=0.8)
        crowds = Job(server.port, PATH, CROWDS, seconds, _crowd(*clips))
        taken, spent = taken_meanwhile(server, crowds)
    due = RATE * np.array(CONNECTIONS)
    kept = float(np.min(np.array(sent) / np.minimum(due, max(sent))))
    findings.add("least messages per second / the lesser of the most and those due", kept, least=0.9)
    slowest = min(len(one.arrivals) for one in taken) / seconds
    findings.add(f"{CROWDS} streams of {CROWD} characters: frames per second of the slowest", slowest, least=59)
    findings.add(f"{CROWDS} streams of {CROWD} characters: share of a core", spent / seconds)
    return findings


def _crowd(locomotions: list[str], actions: list[str]) -> list[str]:
    """Returns messages of commands that create CROWD characters, some of each pair of clips."""
    pairs, messages = [(one, two) for one in locomotions for two in actions], []
    for number, (locomotion, action) in enumerate(pairs):
        ids = list(range(number, CROWD, len(pairs)))
        create = {"do": "create", "id": ids, "locomotion": locomotion, "time": number % 7 / 4}
        messages.append(json.dumps([create, {"do": "act", "id": ids, "action": action}]))
    return messages
