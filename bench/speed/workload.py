"""What characters play in the speed benchmarks, and a copy of the bytes that they touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.rounds import Work
from bench.speed.numpy_twin import NumpyTwin
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import METHODS, POSTURES, Memory, Requests

RATE = 60.0  # ticks per second
SETS = 32  # of requests, which rounds take in turns


@dataclass(frozen=True)
class Scene:
    """What characters play: one clip pair or any (`many`), at times that go on by a tick each round, or at any."""

    many: bool = True
    sequential: bool = False

    @property
    def label(self) -> str:
        return f"{'many pairs' if self.many else 'one pair'}, {'sequential' if self.sequential else 'random'} times"


def request_sets(
    bank: Bank, count: int, scene: Scene, method: str = "splice", posture: str = "relative", seed: int = 0
) -> list[Requests]:
    """SETS sets of requests of `count` characters; work that runs in turns needs seeds of its own, or it finds in the
    caches what other work brought there."""
    draw = np.random.default_rng(seed)
    clips = len(bank.clips)
    locomotion, action = draw.integers(0, clips, (2, count)) if scene.many else np.array([[0], [clips - 1]])
    durations = np.array([clip.duration for clip in bank.clips])
    lasts = np.broadcast_to(durations[locomotion], count)
    begun, sets = draw.random(count) * lasts, []
    for number in range(SETS):
        requests = Requests.empty(count)
        requests.locomotion[:], requests.action[:] = locomotion, action
        times = np.mod(begun + number / RATE, lasts) if scene.sequential else draw.random(count) * lasts
        requests.time[:], requests.method[:], requests.posture[:] = times, METHODS[method], POSTURES[posture]
        sets.append(requests)
    return sets


def evaluation(evaluator: Evaluator, sets: Sequence[Requests], memory: Memory | None = None) -> Work:
    """Evaluates one set a round into poses of its own."""
    poses = evaluator.poses(len(sets[0]))
    return lambda number: evaluator.evaluate(sets[number % len(sets)], poses, memory)


def twin_evaluation(twin: NumpyTwin, evaluator: Evaluator, sets: Sequence[Requests]) -> Work:
    """The same, by the NumPy twin."""
    poses = evaluator.poses(len(sets[0]))
    return lambda number: twin.evaluate(sets[number % len(sets)], poses)


class Copy:
    """The floor: copies what a set of requests reads and writes, and computes nothing.

    The very rows of both tables, two neighbours of each per character, as whole items into an array that is there, and
    as many bytes of poses from one array to another. Which rows these are is worked out beforehand. An evaluator
    that has its rows fetched ahead, and need not write them, can be faster where they come from memory.
    """

    def __init__(self, bank: Bank, sets: Sequence[Requests]) -> None:
        count, joints = len(sets[0]), bank.skeleton.joint_count
        twin, halves = NumpyTwin(bank), bank.layout.halves
        # An item is a row, and a void one so that NumPy moves it whole.
        items = {name: np.dtype((np.void, 4 * half.columns)) for name, half in halves.items()}
        self._tables = [bank.tables[name].view(items[name])[:, 0] for name in items]
        self._rows = [
            [np.stack([place.rows, place.rows + 1], axis=1).ravel() for place in twin.places(one)] for one in sets
        ]
        self._room = [np.empty(2 * count, item) for item in items.values()]
        self._poses, self._out = np.zeros((2, count, 3 + 4 * joints), np.float32)

    def run(self, number: int) -> None:
        """Copies for the set of a round."""
        for table, rows, room in zip(self._tables, self._rows[number % len(self._rows)], self._room, strict=True):
            np.take(table, rows, out=room, mode="clip")
        np.copyto(self._out, self._poses)
