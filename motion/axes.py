"""Axes and units of other engines. Frames are converted only when they are encoded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

UP = 1  # our Y
AxesName = Literal["gltf", "unity", "unreal", "godot", "blender"]


@dataclass(frozen=True, eq=False)
class Axes:
    """The conversion from glTF's axes (right-handed, Y up, Z forward, metres), which are ours, to another engine's.

    Component i of a position is our component order[i] times signs[i] times `scale`. Component i of a quaternion's
    vector part is our component order[i] times turns[i].
    """

    name: str
    description: str
    unit: str
    order: tuple[int, int, int]
    signs: tuple[int, int, int]
    scale: float

    @property
    def turns(self) -> tuple[int, int, int]:
        """Signs of a quaternion's x, y and z: those of positions, negated if the axes are left-handed."""
        matrix = np.zeros((3, 3))
        matrix[range(3), self.order] = self.signs
        handed = round(np.linalg.det(matrix))
        return (handed * self.signs[0], handed * self.signs[1], handed * self.signs[2])

    @property
    def turn(self) -> int:
        """Sign of a turn about the up axis: -1 if the axes are left-handed, as the angle of its quaternion there."""
        return self.turns[self.order.index(UP)]

    @property
    def ours(self) -> bool:
        """Whether these are our axes and unit, so that nothing is converted."""
        return self.order == (0, 1, 2) and self.signs == (1, 1, 1) and self.scale == 1.0

    def positions(self, ours: NDArray[np.float64]) -> NDArray[np.float64]:
        """Converts positions or offsets [..., 3] in metres."""
        return np.asarray(ours[..., self.order] * self.signs * self.scale)

    def metres(self, theirs: Sequence[float]) -> list[float]:
        """Converts a position [3] in these axes to ours."""
        ours = [0.0, 0.0, 0.0]
        for one, axis, sign in zip(theirs, self.order, self.signs, strict=True):
            ours[axis] = sign * one / self.scale
        return ours


AXES: Mapping[str, Axes] = {
    axes.name: axes
    for axes in (
        Axes("gltf", "right-handed, Y up, characters face Z", "metre", (0, 1, 2), (1, 1, 1), 1.0),
        Axes("unity", "left-handed, Y up, Z forward", "metre", (0, 1, 2), (-1, 1, 1), 1.0),
        Axes("unreal", "left-handed, Z up, X forward", "centimetre", (2, 0, 1), (1, -1, 1), 100.0),
        Axes("godot", "right-handed, Y up, characters face Z", "metre", (0, 1, 2), (1, 1, 1), 1.0),
        Axes("blender", "right-handed, Z up, characters face -Y", "metre", (0, 2, 1), (1, -1, 1), 1.0),
    )
}
