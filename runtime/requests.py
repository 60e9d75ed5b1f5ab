"""What is asked of the evaluator, and the arrays that it answers in and remembers by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motion.errors import SettingsError, did_you_mean
from runtime import kernels

Method = Literal["splice", "naive", "none"]
Posture = Literal["relative", "absolute", "running", "off"]
METHODS: Mapping[str, int] = {"none": kernels.NONE, "naive": kernels.NAIVE, "splice": kernels.SPLICE}
POSTURES: Mapping[str, int] = {
    "off": kernels.OFF,
    "relative": kernels.RELATIVE,
    "absolute": kernels.ABSOLUTE,
    "running": kernels.RUNNING,
}
TIME_CONSTANT = 2.0  # seconds: about two strides

Float32s = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Requests:
    """What n characters play at one moment; fill the arrays in place, frame by frame.

    locomotion, action: [n] int32 clip numbers (`Bank.number`).
    time:   [n] float64 seconds into the locomotion.
    start:  [n] float64 seconds into the action before which it does not begin; the first frame at or after it
            that is in step with the locomotion's first frame goes with that.
    method, posture: [n] uint8, values of METHODS and POSTURES.
    """

    locomotion: NDArray[np.int32]
    time: NDArray[np.float64]
    action: NDArray[np.int32]
    start: NDArray[np.float64]
    method: NDArray[np.uint8]
    posture: NDArray[np.uint8]

    def rows(self, first: int, stop: int) -> Requests:
        """Characters `first` to `stop` (exclusive), in the same memory."""
        return Requests(*(getattr(self, field.name)[first:stop] for field in fields(self)))

    @classmethod
    def empty(cls, count: int) -> Requests:
        """Room for `count` characters: clip 0 from its start, `splice`, `relative`."""
        return cls(
            locomotion=np.zeros(count, np.int32),
            time=np.zeros(count),
            action=np.zeros(count, np.int32),
            start=np.zeros(count),
            method=np.full(count, kernels.SPLICE, np.uint8),
            posture=np.full(count, kernels.RELATIVE, np.uint8),
        )


@dataclass(frozen=True, eq=False)
class Poses:
    """Room for the poses of n characters: root_positions [n, 3] metres, rotations [n, J, 4] xyzw, both float32."""

    root_positions: Float32s
    rotations: Float32s

    def rows(self, first: int, stop: int) -> Poses:
        """Characters `first` to `stop` (exclusive), in the same memory."""
        return Poses(self.root_positions[first:stop], self.rotations[first:stop])


@dataclass(frozen=True, eq=False)
class RunningPosture:
    """What posture `running` remembers of n characters: the mean posture of each one's splice so far.

    It starts from the locomotion's stored posture, and new frames gain on it with a time constant (Heck's thesis, 4.3).

    means: [n, 2, 3] metres; NaN: not begun, which a character that starts anew is set back to.
    share: how much of a new frame goes into the mean.
    """

    means: NDArray[np.float64]
    share: float

    @classmethod
    def begin(cls, count: int, rate: float, time_constant: float = TIME_CONSTANT) -> RunningPosture:
        """For `count` characters that are evaluated `rate` times per second of motion; time_constant in seconds."""
        return cls(np.full((count, 2, 3), np.nan), 1.0 - math.exp(-1.0 / (rate * time_constant)))


def known(constants: Mapping[str, int], label: str, name: str) -> int:
    """The kernel constant of a method or posture; raises SettingsError if there is none of that name."""
    try:
        return constants[name]
    except KeyError:
        raise SettingsError(f"there is no {label} {name!r}", mend=did_you_mean(name, constants)) from None
