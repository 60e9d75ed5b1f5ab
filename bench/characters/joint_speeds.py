"""Where joints of characters and clips are in the world, and how fast they move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.requests import Poses
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage

RATE = 60.0  # frames a second, of all that is watched


def shown(characters: Characters) -> Floats:
    """World positions [n, J, 3] of all joints."""
    poses = characters.stage.evaluator.poses(len(characters))
    characters.evaluate(poses)
    return in_the_world(characters.stage, poses)


def in_the_world(stage: Stage, poses: Poses) -> Floats:
    positions = np.empty((len(poses.flat), stage.bank.skeleton.joint_count, 3), np.float32)
    stage.evaluator.world_positions(poses, positions)
    return positions.astype(np.float64)


def fastest_of_clip(stage: Stage, name: str) -> float:
    """Metres a second of the fastest joint of a clip by itself."""
    times = np.arange(0.0, stage.bank.clip(name).duration, 1.0 / RATE)
    positions = in_the_world(stage, stage.evaluator.sequence(Splice(name), times))
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=-1).max()) * RATE


class Watch:
    """The fastest that a joint of each character has moved [n], metres a second, and the most that its velocity has
    changed from one frame to the next."""

    def __init__(self, count: int) -> None:
        self.speed, self.jump = np.zeros(count), np.zeros(count)
        self._positions: Floats | None = None
        self._velocities: Floats | None = None
        self._counted = np.zeros(count, np.bool_)

    def see(self, positions: Floats, counted: NDArray[np.bool_] | None = None) -> None:
        """The joints [n, J, 3] of the next frame, and for which characters [n] it counts (all, if not given)."""
        counts = np.ones(len(positions), np.bool_) if counted is None else counted
        velocities = None
        if self._positions is not None:
            velocities = (positions - self._positions) * RATE
            self._most(self.speed, velocities, counts)
            if self._velocities is not None:
                self._most(self.jump, velocities - self._velocities, counts & self._counted)
        self._positions, self._velocities, self._counted = positions, velocities, counts

    @staticmethod
    def _most(most: Floats, vectors: Floats, counts: NDArray[np.bool_]) -> None:
        np.maximum(most, counts * np.linalg.norm(vectors, axis=-1).max(axis=-1), out=most)
