"""The part of a bank for a standing action, which has no gait: how it departs from its stance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Standing:
    """How a standing action departs from its stance at n frames (docs/method.md).

    Attributes:
        stance: [J, 4] local rotations of the pose from which it departs, xyzw.
        turns: [n, 4] how the pelvis is turned from the stance, in the posture frame, xyzw.
        usage: [n, PARTS] from 0, where a part moves with the locomotion, to 1, where the action alone poses it.
        parts: Bits of the parts that it drives at all.
    """

    stance: NDArray[np.float64]
    turns: NDArray[np.float64]
    usage: NDArray[np.float64]
    parts: int
