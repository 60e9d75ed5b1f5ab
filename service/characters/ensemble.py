"""Scenes whose characters are advanced and evaluated by one call."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.character import Characters
from motionsplice.runtime.requests import Poses
from motionsplice.service.characters.scene import Scene

MOST_JOINED = 64  # characters of a scene; after each command the states of joined scenes are copied


class Ensemble:
    """Scenes of one edition and rate. The states of their characters are one array, of which each scene has a slice.

    Attributes:
        scenes: The scenes.
        characters: The characters of all scenes, in order.
        ends: For each scene, the row after its last.
    """

    def __init__(self, scenes: Sequence[Scene]) -> None:
        self.scenes = list(scenes)
        self.characters = Characters.joined([scene.characters for scene in scenes])
        self.ends = list(accumulate(map(len, scenes)))
        self._states = [scene.characters.state for scene in scenes]
        self._wanted = np.repeat([scene.events for scene in scenes], [len(scene) for scene in scenes])
        self._any = int(np.bitwise_or.reduce(self._wanted))

    def __len__(self) -> int:
        return len(self.characters)

    def holds(self, scenes: Sequence[Scene]) -> bool:
        """Whether it is made of these scenes, and no other ensemble has taken one of them since."""
        states = self._states
        return self.scenes == scenes and all(
            scene.characters.state is state for scene, state in zip(scenes, states, strict=True)
        )

    @property
    def rows(self) -> Iterator[tuple[int, int]]:
        """First row and end of each scene."""
        return pairwise([0, *self.ends])

    def evaluate(self, out: Poses) -> None:
        """Writes the poses of all characters into `out`."""
        self.characters.evaluate(out)

    def advance(self, frames: int = 1) -> list[tuple[int, dict[str, Any]]]:
        """Advances all characters. Returns events, each with the number of its scene."""
        if not self.characters.advance(frames) & self._any:
            return []
        return self._happened()

    def leave_out(self, frames: int, step: int) -> list[tuple[int, int, dict[str, Any]]]:
        """Advances by frames that are not sent, `step` at once. Their root motion is added to that of the next frame.

        Frame by frame, characters move as if the frames had been sent.

        Returns:
            Events, each with the number of frames after which it happened, and the number of its scene.
        """
        found: list[tuple[int, int, dict[str, Any]]] = []
        for first in range(0, frames, step):
            before, count = self.characters.deltas.copy(), min(step, frames - first)
            if count == 1:
                self.characters.remember()
            found += [(first + count, number, event) for number, event in self.advance(count)]
            self.characters.deltas[:] = composed(before, self.characters.deltas)
        return found

    def _happened(self) -> list[tuple[int, dict[str, Any]]]:
        rows = np.flatnonzero(self.characters.events & self._wanted)
        numbers = np.unique(np.searchsorted(self.ends, rows, side="right")).tolist()
        return [(number, event) for number in numbers for event in self.scenes[number].happened()]


def composed(first: NDArray[np.float64], then: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns two steps of root motion [n, 4] as one, relative to the place and heading before the first."""
    left, up, ahead, turn = then.T
    sin, cos = np.sin(first[:, 3]), np.cos(first[:, 3])
    return first + np.column_stack((cos * left + sin * ahead, up, cos * ahead - sin * left, turn))
