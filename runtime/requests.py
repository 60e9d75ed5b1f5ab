"""What is asked of the evaluator, and the arrays that it answers in and remembers by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError, TimeRangeError, did_you_mean
from motionsplice.motion.quaternion import IDENTITY
from motionsplice.runtime.format.manifest import ClipEntry
from motionsplice.runtime.kernels.arrays import LAST_TURN, LATE, MEAN_POSTURE, MEMORY_COLUMNS
from motionsplice.runtime.kernels.lookup import NAIVE, NONE, SPLICE
from motionsplice.runtime.kernels.posture import ABSOLUTE, OFF, RELATIVE, RUNNING

Method = Literal["splice", "naive", "none"]
Posture = Literal["relative", "absolute", "running", "off"]
METHODS: Mapping[str, int] = {"none": NONE, "naive": NAIVE, "splice": SPLICE}
POSTURES: Mapping[str, int] = {"off": OFF, "relative": RELATIVE, "absolute": ABSOLUTE, "running": RUNNING}
FLOAT32, FLOAT64 = np.dtype(np.float32), np.dtype(np.float64)
TIME_CONSTANT = 2.0  # seconds: about two strides

Float32s = NDArray[np.float32]


REQUEST = np.dtype(
    [
        ("locomotion", np.int32),
        ("action", np.int32),
        ("time", np.float64),
        ("start", np.float64),
        ("cycles", np.int32),
        ("method", np.uint8),
        ("posture", np.uint8),
        ("hands", np.uint16),
    ],
    align=True,
)


class Requests:
    """What n characters play at one moment; fill the columns in place, frame by frame.

    locomotion, action: [n] int32 clip numbers (`Bank.number`).
    time:   [n] float64 seconds into the locomotion.
    start:  [n] float64 seconds into the action before which it does not begin; the first frame at or after it
            that is in step with the locomotion's first frame goes with that.
    cycles: [n] int32 whole cycles by which the action is ahead of that; ignored unless the method is `splice`.
    method, posture: [n] uint8, values of METHODS and POSTURES.
    hands:  [n] uint16, 0 for the fingers of the clip that gives the upper body, else 1 more than a number of hands
            (`Bank.hand_number`) that lie on that clip.
    records: [n] REQUEST, the same memory, a record for each character. Raises SettingsError if they are not that.
    """

    def __init__(self, records: NDArray[np.void]) -> None:
        check_array("requests", records, REQUEST, (len(records),))
        self.records = records
        self.locomotion: NDArray[np.int32] = records["locomotion"]
        self.action: NDArray[np.int32] = records["action"]
        self.cycles: NDArray[np.int32] = records["cycles"]
        self.time: NDArray[np.float64] = records["time"]
        self.start: NDArray[np.float64] = records["start"]
        self.method: NDArray[np.uint8] = records["method"]
        self.posture: NDArray[np.uint8] = records["posture"]
        self.hands: NDArray[np.uint16] = records["hands"]

    @classmethod
    def empty(cls, count: int) -> Requests:
        """Room for `count` characters: clip 0 from its start, `splice`, `relative`."""
        requests = cls(np.zeros(count, REQUEST))
        requests.method[:], requests.posture[:] = SPLICE, RELATIVE
        return requests

    def __len__(self) -> int:
        return len(self.records)


class Poses:
    """Room for the poses of n characters: root_positions [n, 3] metres, rotations [n, J, 4] xyzw, both float32.

    Raises SettingsError if an array is of another shape or type, or not side by side in memory.
    """

    def __init__(self, root_positions: Float32s, rotations: Float32s) -> None:
        count, joints = rotations.shape[:2]
        check_array("root positions", root_positions, FLOAT32, (count, 3))
        check_array("rotations", rotations, FLOAT32, (count, joints, 4))
        self.root_positions = root_positions
        self.rotations = rotations
        self.flat: Float32s = rotations.reshape(count, 4 * joints)

    @classmethod
    def empty(cls, count: int, joints: int) -> Poses:
        return cls(np.empty((count, 3), np.float32), np.empty((count, joints, 4), np.float32))


def check_array(what: str, array: NDArray[Any], kind: np.dtype[Any], shape: tuple[int, ...]) -> None:
    """That kernels know an array, lest results be lost in a copy, or a kernel compiled anew. Raises SettingsError."""
    if array.shape != shape or array.dtype != kind or not array.flags.c_contiguous:
        raise SettingsError(
            f"{what} need {kind}{list(shape)}, side by side in memory, and not {array.dtype}{list(array.shape)}",
            mend="Evaluator.poses, Requests.empty and Memory.begin make room",
        )


class Memory:
    """What the evaluator remembers from frame to frame of n characters, or of the one that all requests are about.

    Where a torso's joints lie so that no alignment is clearly the best, the last one is held. For posture `running` it
    is the mean posture of the splice so far, which starts from the locomotion's stored posture and follows new frames
    with a time constant (Heck's thesis, 4.3).

    state: [n, 10] float64, to be saved and restored at will. turns [n, 4], the last alignments, and means [n, 6]
    metres, NaN until they begin, are parts of it. share: how much of a new frame goes into the mean. Raises
    SettingsError if the state is not that.
    """

    def __init__(self, state: NDArray[np.float64], share: float) -> None:
        check_array("memory", state, FLOAT64, (len(state), MEMORY_COLUMNS))
        self.state = state
        self.share = share
        self.turns = state[:, LAST_TURN : LAST_TURN + 4]
        self.means = state[:, MEAN_POSTURE : MEAN_POSTURE + 6]

    @classmethod
    def begin(cls, count: int, rate: float, time_constant: float = TIME_CONSTANT) -> Memory:
        """For `count` characters that are evaluated `rate` times per second of motion; time_constant in seconds."""
        memory = cls(np.empty((count, MEMORY_COLUMNS)), 1.0 - math.exp(-1.0 / (rate * time_constant)))
        memory.forget(slice(None))
        return memory

    def forget(self, characters: int | slice) -> None:
        """For characters that start anew."""
        self.turns[characters], self.means[characters] = IDENTITY, np.nan


def time_fault(label: str, seconds: float, clip: ClipEntry, place: str = "") -> TimeRangeError | None:
    """What is wrong with a time in a clip, if that lies outside it or is not a number."""
    if seconds >= 0.0 and (seconds - LATE) * clip.rate <= clip.frame_count - 1.0:
        return None
    problem = f"{label} {seconds} s lies outside clip {clip.name!r}, which lasts {clip.duration:.3f} s"
    return TimeRangeError(problem, place=place, mend=f"Give a {label} from 0 to {clip.duration:.3f}")


def known(constants: Mapping[str, int], label: str, name: str) -> int:
    """The kernel constant of a method or posture; raises SettingsError if there is none of that name."""
    try:
        return constants[name]
    except KeyError:
        raise SettingsError(f"there is no {label} {name!r}", mend=did_you_mean(name, constants)) from None
