"""One stream of many characters: at its pace, and as fast as it goes."""

from __future__ import annotations

from pathlib import Path

from bench.findings import Findings
from bench.service.banks import names
from bench.service.clients import create, taken_meanwhile
from bench.service.process import serving
from bench.service.statistics import lost
from bench.service.stream_client import Job

CHARACTERS = 4000
FASTER = 1000  # frames per second that are asked for, and not reached


def crowd(bank: Path, *, seconds: float = 8.0) -> Findings:
    """4,000 characters at 60 Hz; then at a rate that nothing can hold, so that frames are made as fast as it goes.

    Frames that the client was too slow for are evaluated and not sent: what they cost counts, and they do not.
    """
    commands = create(CHARACTERS, names(bank, "locomotion"), names(bank, "action"))
    told = Findings(f"One stream of {CHARACTERS} characters, {seconds:g} s")
    with serving(bank, "--max-load", "1e9", "--max-rate", "1000") as server:
        for numbers in ("int16", "float32"):
            path = f"/v1/characters?encoding={numbers}&rate="
            (taken,), spent = taken_meanwhile(server, Job(server.port, f"{path}60", 1, seconds, commands))
            told.add(f"{numbers}, 60 Hz: share of a core", spent / seconds, most=0.5)
            told.add(f"{numbers}, 60 Hz: frames lost", lost(taken.numbers), "{:.0f}", most=0)
            size = taken.bytes / len(taken.arrivals) / CHARACTERS
            told.add(f"{numbers}: bytes per character and frame", size, "{:.0f}")
            (taken,), spent = taken_meanwhile(server, Job(server.port, f"{path}{FASTER}", 1, seconds, commands))
            per_second = len(taken.arrivals) * CHARACTERS / spent
            told.add(f"{numbers}, unpaced: characters sent per second and core", per_second, "{:,.0f}", least=1e6)
    return told
