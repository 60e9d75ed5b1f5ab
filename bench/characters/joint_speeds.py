"""World positions of the joints of characters and clips, and how fast they move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.requests import Poses
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage

RATE = 60.0  # frames per second of all measurements of characters


def character_positions(characters: Characters) -> Floats:
    """Evaluates characters, and returns the world positions [n, J, 3] of all joints in metres."""
    poses = characters.stage.evaluator.poses(len(characters))
    characters.evaluate(poses)
    return pose_positions(characters.stage, poses)


def pose_positions(stage: Stage, poses: Poses) -> Floats:
    """Returns the world positions [n, J, 3] of all joints of poses in metres."""
    positions = np.empty((len(poses.flat), stage.bank.skeleton.joint_count, 3), np.float32)
    stage.evaluator.world_positions(poses, positions)
    return positions.astype(np.float64)


def fastest_of_clip(stage: Stage, name: str) -> float:
    """Returns the speed of the fastest joint of a clip played alone, metres per second."""
    times = np.arange(0.0, stage.bank.clip(name).duration, 1.0 / RATE)
    positions = pose_positions(stage, stage.evaluator.sequence(Splice(name), times))
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=-1).max()) * RATE


class Watch:
    """Keeps, for each of n characters, the maximum over joints and frames of two quantities.

    speed [n]: the speed of a joint. jump [n]: the change of a joint's velocity from one frame to the next. Both are in
    metres per second.
    """

    def __init__(self, count: int) -> None:
        self.speed, self.jump = np.zeros(count), np.zeros(count)
        self._positions: Floats | None = None
        self._velocities: Floats | None = None
        self._counted = np.zeros(count, np.bool_)

    def add(self, positions: Floats, counted: NDArray[np.bool_] | None = None) -> None:
        """Adds the joint positions [n, J, 3] of the next frame, for the characters that are `counted` [n], or all."""
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
