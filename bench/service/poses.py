"""GET /v1/pose from many connections that are kept alive, and what a server could do at best."""

from __future__ import annotations

from pathlib import Path
from statistics import median

import numpy as np

from bench.precompute import in_process
from bench.service.asking import Asked, ask, get
from bench.service.cast import BANK, clip_names
from bench.service.control import control
from bench.service.servers import Endpoint, service
from bench.service.tables import at_least, at_most, milliseconds, percent, show
from bench.targets import Target

REQUESTS = 4096  # different ones
FEW = 32  # pairs of clips, as a game plays at a time
MSGPACK, JSON = "MessagePack, 32 pairs", "JSON, 32 pairs"


def measure(bank: Path, connections: int, seconds: float, rounds: int) -> list[Target]:
    """Prints what a pose costs, and whether that is as wanted."""
    with service(bank) as ours:
        size = round(in_process(ask, ours, requests("msgpack", FEW), 1, 1.0).body)
        with control("uvicorn", size) as bare, control("bytes", size) as none:
            asked: dict[str, tuple[Endpoint, list[bytes]]] = {
                MSGPACK: (ours, requests("msgpack", FEW)),
                "MessagePack, any pair": (ours, requests("msgpack", REQUESTS)),
                JSON: (ours, requests("json", FEW)),
                "bare uvicorn, as many bytes": (bare, [get("/")]),
                "no server, as many bytes": (none, [get("/")]),
            }
            runs: dict[str, list[Asked]] = {name: [] for name in asked}
            for _ in range(rounds):
                for name, (endpoint, some) in asked.items():
                    runs[name].append(in_process(ask, endpoint, some, connections, seconds))
    columns = ["GET /v1/pose", "per core", "us of a core", "per second", "p50 ms", "p99 ms", "CPU", "client", "bytes"]
    title = f"{connections} connections kept alive, {rounds} x {seconds:g} s; the last row is the client's own limit"
    show(title, columns, [row(name, some) for name, some in runs.items()])
    of_ours = runs[MSGPACK]
    return [
        at_least("poses: per second of a core", median(one.per_core for one in of_ours), 15_000),
        at_most("poses: p99, ms", 1e3 * median(np.percentile(one.latencies, 99) for one in of_ours), 3.0),
    ]


def requests(form: str, pairs: int) -> list[bytes]:
    """Requests for poses of as many different pairs at most, each at another time."""
    random, names = np.random.default_rng(0), clip_names()
    known = [random.choice(names, 2, replace=False).tolist() for _ in range(pairs)]
    made = []
    for number in range(REQUESTS):
        (locomotion, action), time = known[number % pairs], BANK.seconds * random.random()
        query = f"locomotion={locomotion}&action={action}&time={time:.4f}&format={form}"
        made.append(get(f"/v1/pose?{query}"))
    return made


def row(name: str, runs: list[Asked]) -> list[str]:
    """Medians over runs."""
    per_core = median(one.per_core for one in runs)
    return [
        name,
        f"{per_core:,.0f}",
        f"{1e6 / per_core:.1f}",
        f"{median(one.per_second for one in runs):,.0f}",
        *(milliseconds(median(np.percentile(one.latencies, part) for one in runs)) for part in (50, 99)),
        percent(median(one.cpu for one in runs)),
        percent(median(one.client_cpu for one in runs)),
        f"{runs[-1].body:,.0f}",
    ]
