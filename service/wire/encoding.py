"""Encodes poses as arrays: axes, number format, and rotations or positions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.axes import AXES, Axes
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Poses
from motionsplice.service.wire.encode_kernels import convert, shorten

Numbers = Literal["float32", "int16"]
Parts = Literal["local", "world", "both"]
NUMBERS: tuple[str, ...] = get_args(Numbers)
PARTS: tuple[str, ...] = get_args(Parts)
INT16_ERROR = 0.0035  # degrees: the largest error of a rotation in int16

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Encoding:
    """The encoding of a client's frames."""

    axes: Axes = AXES["gltf"]
    numbers: str = "float32"
    parts: str = "local"

    @property
    def fields(self) -> dict[str, str]:
        """The query parameters that ask for this encoding."""
        return {"axes": self.axes.name, "encoding": self.numbers, "parts": self.parts}

    @property
    def is_in_place(self) -> bool:
        """Whether all arrays are those of the poses, which are neither converted nor completed."""
        return self.axes.ours and self.numbers == "float32" and self.parts == "local"

    def arrays(self, evaluator: Evaluator, poses: Poses) -> Arrays:
        """Returns `root_positions` [n, 3] and, by `parts`, `rotations` [n, J, 4] and `world_positions` [n, J, 3].

        They may share memory with `poses`: send or copy them before `poses` is evaluated again.
        """
        arrays: Arrays = {"root_positions": self._positions(poses.root_positions)}
        if self.parts != "world":
            arrays["rotations"] = self._rotations(poses.rotations)
        if self.parts != "local":
            count, joints, _ = poses.rotations.shape
            world = np.empty((count, joints, 3), np.float32)
            evaluator.world_positions(poses, world)
            arrays["world_positions"] = self._positions(world)
        return arrays

    def _positions(self, metres: NDArray[np.float32]) -> NDArray[np.float32]:
        return metres if self.axes.ours else _converted(metres, *self._of_positions)

    def _rotations(self, ours: NDArray[np.float32]) -> NDArray[Any]:
        turned = ours if self.axes.ours else _converted(ours, *self._of_rotations)
        if self.numbers == "float32":
            return turned
        short = np.empty(turned.shape, np.int16)
        shorten(turned.reshape(-1), short.reshape(-1))
        return short

    @cached_property
    def _of_positions(self) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        axes = self.axes
        return np.array(axes.order), np.array([axes.scale * sign for sign in axes.signs], np.float32)

    @cached_property
    def _of_rotations(self) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        return np.array([*self.axes.order, 3]), np.array([*self.axes.turns, 1], np.float32)


def warm() -> None:
    """Compiles the kernels, or loads them from the cache."""
    rows = np.zeros((1, 4), np.float32)
    _converted(rows, np.arange(4), np.ones(4, np.float32))
    shorten(rows.reshape(-1), np.empty(4, np.int16))


def _converted(
    ours: NDArray[np.float32], order: NDArray[np.int64], factors: NDArray[np.float32]
) -> NDArray[np.float32]:
    out = np.empty_like(ours)
    width = len(order)
    convert(ours.reshape(-1, width), order, factors, out.reshape(-1, width))
    return out
