"""Requests for the speed benchmarks, and a copy of the bytes that they read and write."""

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
SETS = 32  # sets of requests; each round takes the next one


@dataclass(frozen=True)
class Scene:
    """A choice of what characters play: one pair of clips or random pairs (`many`), at random or `sequential` times.

    Sequential times advance by a tick per round.
    """

    many: bool = True
    sequential: bool = False

    @property
    def label(self) -> str:
        return f"{'many pairs' if self.many else 'one pair'}, {'sequential' if self.sequential else 'random'} times"


def request_sets(
    bank: Bank, count: int, scene: Scene, method: str = "splice", posture: str = "relative", seed: int = 0
) -> list[Requests]:
    """Returns SETS sets of requests for `count` characters.

    Interleaved pieces of work need different seeds, because otherwise they find each other's rows in the caches.
    """
    draw = np.random.default_rng(seed)
    clips = len(bank.clips)
    locomotion, action = draw.integers(0, clips, (2, count)) if scene.many else np.array([[0], [clips - 1]])
    durations = np.array([clip.duration for clip in bank.clips])
    lengths = np.broadcast_to(durations[locomotion], count)
    starts, sets = draw.random(count) * lengths, []
    for number in range(SETS):
        requests = Requests.empty(count)
        requests.locomotion[:], requests.action[:] = locomotion, action
        times = np.mod(starts + number / RATE, lengths) if scene.sequential else draw.random(count) * lengths
        requests.time[:], requests.method[:], requests.posture[:] = times, METHODS[method], POSTURES[posture]
        sets.append(requests)
    return sets


def evaluation(evaluator: Evaluator, sets: Sequence[Requests], memory: Memory | None = None) -> Work:
    """Work that evaluates one set of requests per round into its own poses."""
    poses = evaluator.poses(len(sets[0]))
    return lambda number: evaluator.evaluate(sets[number % len(sets)], poses, memory)


def twin_evaluation(twin: NumpyTwin, evaluator: Evaluator, sets: Sequence[Requests]) -> Work:
    """The same work, done by the NumPy twin."""
    poses = evaluator.poses(len(sets[0]))
    return lambda number: twin.evaluate(sets[number % len(sets)], poses)


class Copy:
    """The floor: copies the bytes that a set of requests reads and writes, and computes nothing.

    It copies the same rows of both tables, two neighbouring rows of each per character, as whole items into an existing
    array. It also copies as many bytes as the poses have. The rows are determined beforehand. An evaluator prefetches
    its rows and does not write them, so it can be faster than this when rows come from memory.
    """

    def __init__(self, bank: Bank, sets: Sequence[Requests]) -> None:
        count, joints = len(sets[0]), bank.skeleton.joint_count
        twin, halves = NumpyTwin(bank), bank.layout.halves
        # An item is a whole row, of a void type, so that NumPy copies it in one piece.
        items = {name: np.dtype((np.void, 4 * half.columns)) for name, half in halves.items()}
        self._tables = [bank.tables[name].view(items[name])[:, 0] for name in items]
        self._rows = [
            [np.stack([place.rows, place.rows + 1], axis=1).ravel() for place in twin.places(requests)]
            for requests in sets
        ]
        self._room = [np.empty(2 * count, item) for item in items.values()]
        self._poses, self._out = np.zeros((2, count, 3 + 4 * joints), np.float32)

    def run(self, number: int) -> None:
        """Copies the bytes of one round's set."""
        for table, rows, room in zip(self._tables, self._rows[number % len(self._rows)], self._room, strict=True):
            np.take(table, rows, out=room, mode="clip")
        np.copyto(self._out, self._poses)
