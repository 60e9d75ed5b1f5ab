"""POST /v1/poses, against evaluation and encoding alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import process_time

import msgpack
import numpy as np

from bench.precompute import in_process
from bench.service.asking import Asked, ask, post
from bench.service.cast import BANK, clip_names
from bench.service.poses import row
from bench.service.servers import Endpoint, service
from bench.service.tables import at_most, show
from bench.targets import Target
from runtime.bank import Bank
from runtime.evaluator import Evaluator
from runtime.requests import Requests
from service.wire.encoding import Encoding
from service.wire.messages import packed

BODIES = 32  # different ones, taken in turns
MEDIA_TYPE = "application/msgpack"


@dataclass(frozen=True, eq=False)
class Crowd:
    """What n characters play: clips by number, and times, seconds."""

    locomotion: np.ndarray[tuple[int], np.dtype[np.int32]]
    action: np.ndarray[tuple[int], np.dtype[np.int32]]
    time: np.ndarray[tuple[int], np.dtype[np.float64]]

    @classmethod
    def of(cls, count: int, seed: int) -> Crowd:
        """Any pairs at any times."""
        random = np.random.default_rng(seed)
        locomotion, action = random.integers(0, BANK.clips, (2, count), np.int32)
        return cls(locomotion, action, BANK.seconds * random.random(count))

    def body(self) -> bytes:
        """As POST /v1/poses takes it."""
        columns = {key: column.tobytes() for key, column in vars(self).items()}
        return bytes(msgpack.packb({"clips": clip_names(), **columns}))

    def requests(self) -> Requests:
        """As the evaluator takes it; clips of a generated bank are in order of name."""
        requests = Requests.empty(len(self.time))
        requests.locomotion[:], requests.action[:], requests.time[:] = self.locomotion, self.action, self.time
        return requests


def measure(bank: Path, characters: int, seconds: float, rounds: int) -> list[Target]:
    """Prints what a batch costs, and whether the way around evaluation costs more than that."""
    forms = ("float32", "int16")
    runs: dict[str, list[tuple[Asked, float]]] = {form: [] for form in forms}
    with service(bank) as ours:
        for _ in range(rounds):
            for form in forms:
                runs[form].append(in_process(load, ours, bank, characters, form, seconds))
    table, ratios = [], {}
    for form, some in runs.items():
        alone = median(seconds for _, seconds in some)
        ratios[form] = median(1.0 / one.per_core / seconds for one, seconds in some)
        table.append([*row(form, [one for one, _ in some]), f"{1e6 * alone:.1f}", f"{ratios[form]:.2f}"])
    columns = ["POST /v1/poses", "per core", "us of a core", "per second", "p50 ms", "p99 ms", "CPU", "client", "bytes"]
    title = f"{characters} characters, one connection, {rounds} x {seconds:g} s; alone: evaluation and encoding"
    show(title, [*columns, "alone us", "over that"], table)
    return [at_most(f"batch: {form}, computing time over evaluation and encoding", ratios[form], 2.0) for form in forms]


def load(endpoint: Endpoint, bank: Path, characters: int, form: str, seconds: float) -> tuple[Asked, float]:
    """What was asked and answered, and the seconds that one batch takes to evaluate and encode in this process."""
    crowds = [Crowd.of(characters, seed) for seed in range(BODIES)]
    path = f"/v1/poses?format=msgpack&encoding={form}"
    asked = ask(endpoint, [post(path, MEDIA_TYPE, one.body()) for one in crowds], 1, seconds)
    return asked, cpu_of(evaluation(Bank.open(bank, verify=False), crowds, form), seconds)


def evaluation(bank: Bank, crowds: list[Crowd], form: str) -> Callable[[int], object]:
    """Evaluates and encodes one crowd after the other."""
    evaluator, encoding, every = Evaluator(bank), Encoding(numbers=form), [one.requests() for one in crowds]

    def evaluate(number: int) -> bytes:
        requests = every[number % len(every)]
        poses = evaluator.poses(len(requests))
        evaluator.evaluate(requests, poses)
        return packed({"bank": bank.digest}, encoding.arrays(evaluator, poses))

    return evaluate


def cpu_of(work: Callable[[int], object], seconds: float) -> float:
    """Computing time of a call, the mean of many in a row, after some that are not timed."""
    for number in range(BODIES):
        work(number)
    began, calls = process_time(), 0
    while process_time() - began < seconds:
        work(calls)
        calls += 1
    return (process_time() - began) / calls
