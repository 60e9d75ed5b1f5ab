"""The evaluator's inputs and outputs: requests, poses and memories, as flat arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError, TimeRangeError, did_you_mean
from motionsplice.motion.quaternion import IDENTITY
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.format.entries import ClipEntry
from motionsplice.runtime.kernels.arrays import LAST_TURN, LATE, MEAN_POSTURE, MEMORY_COLUMNS
from motionsplice.runtime.kernels.lookup import NAIVE, NONE, SPLICE
from motionsplice.runtime.kernels.posture import ABSOLUTE, OFF, RELATIVE, RUNNING

Method = Literal["splice", "naive", "none"]
Posture = Literal["relative", "absolute", "running", "off"]
METHODS: Mapping[str, int] = {"none": NONE, "naive": NAIVE, "splice": SPLICE}
"""The number of each method in `Requests.method`, by name."""
POSTURES: Mapping[str, int] = {"off": OFF, "relative": RELATIVE, "absolute": ABSOLUTE, "running": RUNNING}
"""The number of each posture in `Requests.posture`, by name."""
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


class Fixed:
    """Arrays that are views of each other, set once by `_set` and then written in place.

    Raises:
        SettingsError: An attribute is assigned to.
    """

    MADE_OF: ClassVar[tuple[str, ...]]  # the arguments of the constructor

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        """Copies and pickles are made anew: the arrays of a copy would no longer be views of each other."""
        return type(self), tuple(getattr(self, name) for name in self.MADE_OF)

    def _set(self, **attributes: object) -> Self:
        vars(self).update(attributes)
        return self

    def __setattr__(self, name: str, value: object) -> None:
        if name in vars(self) and value is vars(self)[name]:  # after `requests.time += 1.0`, which is in place
            return
        raise SettingsError(f"{name!r} cannot be set", mend="Write into arrays in place, as in requests.time[:] = ...")


class Requests(Fixed):
    """The splices of n characters at one moment, as a structure of arrays. Fill the columns in place, frame by frame.

    Attributes:
        records: [n] REQUEST, one record for each character. All other attributes are views of its columns.
        locomotion: [n] int32, number of the clip that gives root and lower body (`Bank.number`).
        action: [n] int32, number of the clip that gives the upper body.
        time: [n] float64, seconds into the locomotion.
        start: [n] float64, seconds into the action: its earliest frame. The first frame from there on that is in step
            with the locomotion's first frame is played with it. Method `naive` starts at exactly this time.
        cycles: [n] int32, whole cycles to add to the action's phase; for an action captured standing, strides of the
            locomotion's loop to add to its time. Only method `splice` uses it.
        method: [n] uint8, values of METHODS.
        posture: [n] uint8, values of POSTURES.
        hands: [n] uint16, 0 for the fingers of the clip that gives the upper body; else 1 + the number of hands
            (`Bank.hand_number`) that are aligned to this clip.

    Raises:
        SettingsError: `records` has another type or shape, or is not contiguous.

    Example:
        ```python
        from motionsplice import Bank, Evaluator, Requests

        bank = Bank.open("demo/bank")
        evaluator, requests = Evaluator(bank), Requests.empty(1000)
        poses = evaluator.poses(1000)
        requests.locomotion[:] = bank.number("walk")
        requests.action[:] = bank.number("wave")
        for frame in range(60):
            requests.time[:] = frame / 60.0
            evaluator.evaluate(requests, poses)
        ```
    """

    MADE_OF = ("records",)
    records: NDArray[np.void]
    locomotion: NDArray[np.int32]
    action: NDArray[np.int32]
    time: NDArray[np.float64]
    start: NDArray[np.float64]
    cycles: NDArray[np.int32]
    method: NDArray[np.uint8]
    posture: NDArray[np.uint8]
    hands: NDArray[np.uint16]

    def __init__(self, records: NDArray[np.void]) -> None:
        check_array("requests", records, REQUEST, (len(records),), written=False)
        self._set(records=records, **{column: records[column] for column in REQUEST.names or ()})

    @classmethod
    def empty(cls, count: int) -> Requests:
        """Returns `count` requests for clip 0 from its start, with method `splice` and posture `relative`."""
        requests = cls(np.zeros(count, REQUEST))
        requests.method[:], requests.posture[:] = SPLICE, RELATIVE
        return requests

    def __len__(self) -> int:
        return len(self.records)


class Poses(Fixed):
    """Output arrays for the poses of n characters with J joints.

    Attributes:
        root_positions: [n, 3] float32, metres.
        rotations: [n, J, 4] float32, local rotations as quaternions xyzw.
        flat: [n, 4 J] float32, a view of `rotations`.

    Raises:
        SettingsError: An array has another shape or type, or is not contiguous.
    """

    MADE_OF = ("root_positions", "rotations")
    root_positions: Float32s
    rotations: Float32s
    flat: Float32s

    def __init__(self, root_positions: Float32s, rotations: Float32s) -> None:
        count, joints = (*rotations.shape, 1, 1)[:2]
        check_array("root positions", root_positions, FLOAT32, (count, 3))
        check_array("rotations", rotations, FLOAT32, (count, joints, 4))
        self._set(root_positions=root_positions, rotations=rotations, flat=rotations.reshape(count, 4 * joints))

    @classmethod
    def empty(cls, count: int, joints: int) -> Poses:
        """Returns arrays for `count` characters of `joints` joints; their contents are undefined."""
        poses, flat = cls.__new__(cls), np.empty((count, 4 * joints), FLOAT32)
        fields = vars(poses)  # without checks, which take a fifth of a call by name
        fields["root_positions"], fields["flat"] = np.empty((count, 3), FLOAT32), flat
        fields["rotations"] = flat.reshape(count, joints, 4)
        return poses

    def clip(self, name: str, skeleton: Skeleton, rate: float) -> Clip:
        """Returns the poses as frames of a clip, at `rate` frames per second."""
        return Clip(name, skeleton, rate, self.root_positions.astype(np.float64), self.rotations.astype(np.float64))

    def rows(self, first: int, end: int) -> Poses:
        """Returns a view of the poses of characters `first` to `end` - 1."""
        some = {name: array[first:end] for name, array in vars(self).items()}
        return Poses.__new__(Poses)._set(**some)


def check_array(
    what: str, array: NDArray[Any], kind: np.dtype[Any], shape: tuple[int, ...], *, written: bool = True
) -> None:
    """Checks dtype, shape, contiguity and alignment, and whether it may be written: nothing after it does.

    Raises SettingsError.
    """
    flags = array.flags
    fits = array.shape == shape and array.dtype == kind and flags.c_contiguous and flags.aligned
    if not fits or (written and not flags.writeable):
        faults = {
            "not contiguous": not flags.c_contiguous,
            "not aligned": not flags.aligned,
            "read-only": written and not flags.writeable,
        }
        found = ", ".join([f"{array.dtype}{list(array.shape)}", *(name for name, is_so in faults.items() if is_so)])
        raise SettingsError(
            f"{what}: expected a contiguous array {kind}{list(shape)}, found {found}",
            mend="Create arrays with Evaluator.poses, Requests.empty and Memory.begin",
        )


class Memory(Fixed):
    """State of characters that the evaluator keeps between frames: of n, or of one that all requests are about.

    Two things are remembered. If the torso's joints allow no unique best rotation, the last unambiguous one is reused.
    And posture `running` needs the mean posture of the splice so far: it starts from the locomotion's stored posture
    and follows new frames with a time constant (Heck's thesis, 4.3).

    Attributes:
        state: [n, 10] float64, may be saved and restored. NaN where a mean has not begun.
        share: The weight of a new frame in the mean, 0 to 1.
        turns: [n, 4], the last unambiguous rotations as quaternions xyzw, a view of `state`.
        means: [n, 6] metres, mean positions of left and right shoulder in the posture frame, a view of `state`.

    Raises:
        SettingsError: `state` has another type or shape, or is not contiguous.
    """

    MADE_OF = ("state", "share")
    state: NDArray[np.float64]
    share: float
    turns: NDArray[np.float64]
    means: NDArray[np.float64]

    def __init__(self, state: NDArray[np.float64], share: float) -> None:
        check_array("memory", state, FLOAT64, (len(state), MEMORY_COLUMNS))
        turns, means = state[:, LAST_TURN : LAST_TURN + 4], state[:, MEAN_POSTURE : MEAN_POSTURE + 6]
        self._set(state=state, share=share, turns=turns, means=means)

    @classmethod
    def begin(cls, count: int, rate: float, time_constant: float = TIME_CONSTANT) -> Memory:
        """Returns a memory in which nothing has happened yet.

        Args:
            count: Number of characters.
            rate: How often they are evaluated, in frames per second of motion.
            time_constant: Seconds in which the mean posture follows the splice.

        Raises:
            SettingsError: `rate` or `time_constant` is not above 0.
        """
        if not (rate > 0.0 and time_constant > 0.0):
            problem = f"a memory needs a rate and a time constant above 0, found {rate} and {time_constant}"
            raise SettingsError(problem, mend="Give the frames per second at which the characters are evaluated")
        memory = cls(np.empty((count, MEMORY_COLUMNS)), 1.0 - math.exp(-1.0 / (rate * time_constant)))
        memory.forget(slice(None))
        return memory

    def forget(self, characters: int | slice) -> None:
        """Clears the memory of characters that start over."""
        self.turns[characters], self.means[characters] = IDENTITY, np.nan


def time_fault(label: str, seconds: float, clip: ClipEntry, place: str = "") -> TimeRangeError | None:
    """Returns the error if a time in seconds is NaN or outside a clip, else None."""
    if seconds >= 0.0 and (seconds - LATE) * clip.rate <= clip.frame_count - 1.0:
        return None
    problem = f"{label} {seconds} s lies outside clip {clip.name!r}, which lasts {clip.duration:.3f} s"
    return TimeRangeError(problem, place=place, mend=f"Give a {label} from 0 to {clip.duration:.3f}")


def known(constants: Mapping[str, int], label: str, name: str) -> int:
    """Returns the kernel constant of a method, posture, mask or the like; raises SettingsError for an unknown name."""
    try:
        return constants[name]
    except KeyError:
        raise SettingsError(f"unknown {label} {name!r}", mend=did_you_mean(name, constants)) from None
