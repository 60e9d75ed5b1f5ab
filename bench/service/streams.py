"""Streams beside the control: their jitter, lost frames and cost."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench.findings import Findings
from bench.service.banks import names
from bench.service.clients import Streams, Taken, create, taken_meanwhile
from bench.service.process import control, serving
from bench.service.statistics import intervals, jitter, lost, percentiles
from bench.service.stream_client import Job

RATE = 60.0
PATH = "/v1/characters?rate=60&encoding=int16"


def streams(bank: Path, *, connections: int = 64, seconds: float = 10.0, rounds: int = 3) -> Findings:
    """Measures streams of one character each, in turns with as many streams of constant bytes from the control."""
    commands = create(1, names(bank, "locomotion"), names(bank, "action"))
    found: dict[str, list[float]] = {"ours": [], "control": []}
    medians: dict[str, list[float]] = {"ours": [], "control": []}
    placed: dict[str, list[float]] = {"ours": [], "control": []}
    uneven: dict[str, list[float]] = {"ours": [], "control": []}
    gaps = dropped = frames = 0
    share = other_share = memory = 0.0
    with serving(bank) as server:
        sample = Streams(Job(server.port, PATH, 1, 0.5, commands)).taken()[0]
        size = sample.bytes // len(sample.arrivals)
        with control(str(size), str(RATE)) as other:
            for _ in range(rounds):
                for name, one in (("ours", server), ("control", other)):
                    sent = commands if name == "ours" else []
                    taken, spent = taken_meanwhile(one, Job(one.port, PATH, connections, seconds, sent))
                    used = spent / seconds
                    p50, p99 = spread(taken, numbered=name == "ours")
                    placed[name].append(spread(taken, numbered=False)[1])
                    uneven[name].append(percentiles(np.concatenate([intervals(t.arrivals, RATE) for t in taken]))[1])
                    medians[name].append(p50)
                    found[name].append(p99)
                    if name == "ours":
                        gaps += sum(lost(stream.numbers) for stream in taken)
                        dropped += sum(stream.lost for stream in taken)
                        frames += sum(len(stream.numbers) for stream in taken)
                        share, memory = max(share, used), server.memory()
                    else:
                        other_share = max(other_share, used)
        left_out = server.metric("motionsplice_frames_skipped_total")
    findings = Findings(
        f"{connections} streams of one character, {RATE:g} Hz, {rounds} rounds of {seconds:g} s, {size} bytes per frame"
    )
    findings.add("jitter p50, ms", float(np.median(medians["ours"])))
    findings.add("jitter p50 of the control, ms", float(np.median(medians["control"])))
    findings.add("jitter p99, ms", float(np.median(found["ours"])))
    findings.add("jitter p99 of the control, ms", float(np.median(found["control"])))
    ratios = np.array(placed["ours"]) / np.array(placed["control"])
    findings.add(
        "jitter p99 / control, both from the nearest places on the grid (median of rounds)",
        float(np.median(ratios)),
        most=1.3,
    )
    findings.add("deviation of intervals from 1/60 s, p99, ms", float(np.median(uneven["ours"])))
    findings.add("deviation of intervals from 1/60 s, p99 of the control, ms", float(np.median(uneven["control"])))
    between = np.array(uneven["ours"]) / np.array(uneven["control"])
    findings.add(
        "deviation of intervals from 1/60 s, p99 / control (median of rounds)", float(np.median(between)), most=1.3
    )
    findings.add("streams dropped", dropped, "{:.0f}", most=0)
    findings.add("frames left out, which a busy machine causes too", left_out, "{:.0f}")
    findings.add("frames lost, which the service does not know of", max(0.0, gaps - left_out), "{:.0f}", most=0)
    findings.add("frames per second", frames / (rounds * seconds), "{:.0f}")
    findings.add("share of a core", share)
    findings.add("share of a core, control", other_share)
    findings.add("memory, MB", memory, "{:.0f}")
    return findings


def spread(taken: list[Taken], *, numbered: bool = True, skip: int = 30) -> tuple[float, float]:
    """Returns p50 and p99 of the jitter of all streams, in milliseconds, without their first `skip` frames."""
    every = []
    for one in taken:
        numbers = one.numbers if numbered else counted(one.arrivals)
        if len(numbers) > skip:
            every.append(jitter(one.arrivals[skip:], numbers[skip:], RATE))
    return percentiles(np.concatenate(every))


def counted(arrivals: list[float]) -> list[int]:
    """Returns frame numbers for messages without any: the nearest places on the regular grid."""
    if not arrivals:
        return []
    steps = np.asarray(arrivals) - np.median(np.asarray(arrivals) - np.arange(len(arrivals)) / RATE)
    return [int(one) for one in np.round(steps * RATE)]
