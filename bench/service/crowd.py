"""One stream of many characters, at 60 Hz and as fast as possible."""

from __future__ import annotations

from pathlib import Path

from bench.findings import Findings
from bench.service.banks import names
from bench.service.clients import create, taken_meanwhile
from bench.service.process import serving
from bench.service.statistics import lost
from bench.service.stream_client import Job

CHARACTERS = 4000
UNREACHABLE_RATE = 1000  # frames per second; more than the server can send


def crowd(bank: Path, *, seconds: float = 8.0) -> Findings:
    """Measures 4,000 characters at 60 Hz, and then at a rate that cannot be reached, so that frames are not paced.

    When the client is too slow, frames are evaluated but not sent. Their cost counts, but they do not count as sent.
    """
    commands = create(CHARACTERS, names(bank, "locomotion"), names(bank, "action"))
    findings = Findings(f"One stream of {CHARACTERS} characters, {seconds:g} s")
    with serving(bank, "--max-load", "1000000000", "--max-rate", "1000") as server:
        for numbers in ("int16", "float32"):
            path = f"/v1/characters?encoding={numbers}&rate="
            (taken,), spent = taken_meanwhile(server, Job(server.port, f"{path}60", 1, seconds, commands))
            findings.add(f"{numbers}, 60 Hz: share of a core", spent / seconds, most=0.5)
            findings.add(f"{numbers}, 60 Hz: frames lost", lost(taken.numbers), "{:.0f}", most=0)
            size = taken.bytes / len(taken.arrivals) / CHARACTERS
            findings.add(f"{numbers}: bytes per character and frame", size, "{:.0f}")
            (taken,), spent = taken_meanwhile(
                server, Job(server.port, f"{path}{UNREACHABLE_RATE}", 1, seconds, commands)
            )
            per_second = len(taken.arrivals) * CHARACTERS / spent
            findings.add(f"{numbers}, unpaced: characters sent per second and core", per_second, "{:,.0f}", least=1e6)
    return findings
