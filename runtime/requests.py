"""What is asked of the evaluator, and the arrays that it answers in and remembers by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motion.errors import SettingsError, did_you_mean
from motion.quaternion import IDENTITY
from runtime.lookup_kernels import NAIVE, NONE, SPLICE
from runtime.posture_kernels import ABSOLUTE, OFF, RELATIVE, RUNNING

Method = Literal["splice", "naive", "none"]
Posture = Literal["relative", "absolute", "running", "off"]
METHODS: Mapping[str, int] = {"none": NONE, "naive": NAIVE, "splice": SPLICE}
POSTURES: Mapping[str, int] = {"off": OFF, "relative": RELATIVE, "absolute": ABSOLUTE, "running": RUNNING}
TIME_CONSTANT = 2.0  # seconds: about two strides

Float32s = NDArray[np.float32]


REQUEST = np.dtype(
    [
        ("locomotion", np.int32),
        ("action", np.int32),
        ("time", np.float64),
        ("start", np.float64),
        ("method", np.uint8),
        ("posture", np.uint8),
    ],
    align=True,
)


@dataclass(frozen=True, eq=False)
class Requests:
    """What n characters play at one moment, a record each [n] of REQUEST; fill it in place, frame by frame.

    locomotion, action: clip numbers (`Bank.number`).
    time:   seconds into the locomotion.
    start:  seconds into the action before which it does not begin; the first frame at or after it that is in step with
            the locomotion's first frame goes with that.
    method, posture: values of METHODS and POSTURES.
    """

    records: NDArray[np.void]

    @classmethod
    def empty(cls, count: int) -> Requests:
        """Room for `count` characters: clip 0 from its start, `splice`, `relative`."""
        records = np.zeros(count, REQUEST)
        records["method"], records["posture"] = SPLICE, RELATIVE
        return cls(records)

    def __len__(self) -> int:
        return len(self.records)

    @property
    def locomotion(self) -> NDArray[np.int32]:
        return self.records["locomotion"]

    @property
    def action(self) -> NDArray[np.int32]:
        return self.records["action"]

    @property
    def time(self) -> NDArray[np.float64]:
        return self.records["time"]

    @property
    def start(self) -> NDArray[np.float64]:
        return self.records["start"]

    @property
    def method(self) -> NDArray[np.uint8]:
        return self.records["method"]

    @property
    def posture(self) -> NDArray[np.uint8]:
        return self.records["posture"]


@dataclass(frozen=True, eq=False)
class Poses:
    """Room for the poses of n characters: root_positions [n, 3] metres, rotations [n, J, 4] xyzw, both float32."""

    root_positions: Float32s
    rotations: Float32s


@dataclass(frozen=True, eq=False)
class Memory:
    """What the evaluator remembers from frame to frame of n characters, or of the one that all requests are about.

    Where a torso's joints lie so that no alignment is clearly the best, the last one is held. For posture `running` it
    is the mean posture of the splice so far, which starts from the locomotion's stored posture and follows new frames
    with a time constant (Heck's thesis, 4.3).

    turns: [n, 4] the last alignments. means: [n, 2, 3] metres; NaN: not begun. share: how much of a new frame goes
    into the mean.
    """

    turns: NDArray[np.float64]
    means: NDArray[np.float64]
    share: float

    @classmethod
    def begin(cls, count: int, rate: float, time_constant: float = TIME_CONSTANT) -> Memory:
        """For `count` characters that are evaluated `rate` times per second of motion; time_constant in seconds."""
        turns = np.tile(IDENTITY, (count, 1))
        return cls(turns, np.full((count, 2, 3), np.nan), 1.0 - math.exp(-1.0 / (rate * time_constant)))

    def forget(self, character: int) -> None:
        """For a character that starts anew."""
        self.turns[character], self.means[character] = IDENTITY, np.nan


def known(constants: Mapping[str, int], label: str, name: str) -> int:
    """The kernel constant of a method or posture; raises SettingsError if there is none of that name."""
    try:
        return constants[name]
    except KeyError:
        raise SettingsError(f"there is no {label} {name!r}", mend=did_you_mean(name, constants)) from None
