"""The evaluator: checks requests, then lets kernels write poses into the caller's arrays."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from threading import Lock

import numba
import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError, TimeRangeError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels import evaluate as kernels
from motionsplice.runtime.kernels import stretches as stretch_kernels
from motionsplice.runtime.kernels import world as world_kernels
from motionsplice.runtime.kernels.lookup import NONE
from motionsplice.runtime.request_faults import check_room, fault_of
from motionsplice.runtime.requests import (
    FLOAT32,
    METHODS,
    POSTURES,
    Float32s,
    Memory,
    Poses,
    Requests,
    check_array,
    known,
)
from motionsplice.runtime.simd.entry import entry_of
from motionsplice.runtime.simd.handle import handle_of
from motionsplice.runtime.splice import Splice

NO_MEMORY = Memory(np.empty((0, arrays.MEMORY_COLUMNS)), 0.0)
ONE_AT_A_TIME = Lock()  # some of Numba's threading layers crash when two parallel kernels run at once


class Evaluator:
    """Evaluates splices of a bank's clips, in constant time per character and frame (Heck's thesis, 4.3).

    An evaluator owns scratch memory, so threads must not share it: make one for each thread, over the same bank.

    Args:
        bank: The bank.
        threads: Number of threads among which a batch is divided.

    Attributes:
        bank: The bank.
        arrays: The bank as flat arrays for kernels.
        scratch: Scratch memory of the kernels.

    Raises:
        SettingsError: `threads` is below 1 or above the number of Numba's threads.

    Example:
        ```python
        from motionsplice import Bank, Evaluator, Splice

        evaluator = Evaluator(Bank.open("demo/bank"))
        pose = evaluator.pose(Splice("walk", "carry_box"), time=1.5)
        print(pose.root_positions[0], pose.rotations.shape)
        clip = evaluator.clip(Splice("walk", "carry_box"))
        ```
    """

    def __init__(self, bank: Bank, *, threads: int = 1) -> None:
        most = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
        if not 1 <= threads <= most:
            raise SettingsError(f"cannot use {threads} threads", mend=f"Give 1 to {most}")
        self.bank = bank
        self._threads = threads
        self._joints = bank.skeleton.joint_count
        self.arrays = arrays.bank_arrays(bank)
        self.scratch = arrays.scratch(self.arrays, threads)
        self._handle = handle_of(arrays.SpliceArrays(self.arrays, self.scratch))
        self._rig = handle_of(world_kernels.rig_arrays(bank.skeleton))
        self._one, self._last = Requests.empty(1), Splice("")  # the request of `pose`, and the splice that it is for
        self._has_hybrids = any(clip.stretches for clip in bank.clips)

    def __reduce__(self) -> tuple[Callable[..., Evaluator], tuple[Bank]]:
        """Copies and pickles are made anew, because a handle is of this process and of these arrays only."""
        return partial(type(self), threads=self._threads), (self.bank,)

    def poses(self, count: int) -> Poses:
        """Returns arrays for the poses of `count` characters; their contents are undefined."""
        return Poses.empty(count, self._joints)

    def evaluate(self, requests: Requests, out: Poses, memory: Memory | None = None) -> None:
        """Writes the pose of each request into `out`. If a request is invalid, nothing is written.

        Args:
            requests: n requests.
            out: Arrays for n poses.
            memory: Required for posture `running`. A memory of n characters is advanced by one frame. A memory of one
                character is advanced by n frames: all requests are then about this character, in order of time.

        Raises:
            TimeRangeError: A time or start is NaN or outside its clip. Names the first invalid request.
            SettingsError: A clip, method, posture or hands number is unknown, hands are not aligned to the clip that
                gives the upper body, posture `running` has no memory, or sizes differ.
        """
        check_room(requests, out, memory, self._joints)
        self._evaluate_any(requests, out, memory)

    def _evaluate_any(self, requests: Requests, out: Poses, memory: Memory | None) -> None:
        if self._has_hybrids and stretch_kernels.shows_hybrids(self._handle, requests.records):
            self._evaluate_stretches(requests, out, memory)
        else:
            self._evaluate(requests, out, memory)

    def _evaluate(self, requests: Requests, out: Poses, memory: Memory | None) -> None:
        records, roots, flat = requests.records, out.root_positions, out.flat
        remembered = NO_MEMORY if memory is None else memory
        state, share = remembered.state, remembered.share
        if self._threads == 1 or len(state) == 1:
            fault = self._evaluate_alone(self._handle, records, state, share, roots, flat)
        else:
            with ONE_AT_A_TIME:
                numba.set_num_threads(self._threads)
                fault = kernels.evaluate_in_parallel(self._handle, records, state, share, roots, flat)
        if fault >= 0:
            raise fault_of(self.bank, self.arrays, requests, fault)

    @cached_property
    def _evaluate_alone(self) -> Callable[..., int]:
        """The kernel for one thread. Its arrays are checked where requests, poses and memories are made."""
        out = self.poses(1)
        rest = NO_MEMORY.state, NO_MEMORY.share, out.root_positions, out.flat
        return entry_of(kernels.evaluate, self._handle, self._one.records, *rest)

    def _evaluate_stretches(self, requests: Requests, out: Poses, memory: Memory | None) -> None:
        """Evaluates the stretches that hybrids show; where one takes over, blends it with the one before."""
        now, before, shares = self._resolved(requests)
        rows = np.flatnonzero(shares < 1.0)
        if len(rows) > 0:
            faded, poses = Requests(before.records[rows]), self.poses(len(rows))
            kept = None
            if memory is not None:
                remembered = rows if len(memory.state) == len(requests) else slice(None)
                kept = Memory(memory.state[remembered].copy(), memory.share)
            self._evaluate(faded, poses, kept)
        self._evaluate(now, out, memory)
        if len(rows) > 0:
            stretch_kernels.blend(out.flat, poses.flat, rows, shares)

    def _resolved(self, requests: Requests) -> tuple[Requests, Requests, NDArray[np.float64]]:
        """Returns requests for the stretches that hybrids show, for those before, and the shares [n] of the former.

        Raises TimeRangeError or SettingsError for an invalid request.
        """
        now, before = Requests(requests.records.copy()), Requests(requests.records.copy())
        shares = np.empty(len(requests))
        fault = stretch_kernels.resolve(self._handle, requests.records, now.records, before.records, shares)
        if fault >= 0:
            raise fault_of(self.bank, self.arrays, requests, fault)
        return now, before, shares

    def world_positions(self, poses: Poses, out: Float32s) -> None:
        """Writes the world positions of all joints by forward kinematics.

        Args:
            poses: n evaluated poses.
            out: [n, J, 3] float32, metres.

        Raises:
            SettingsError: `out` or `poses` has another shape.
        """
        count = len(poses.flat)
        check_array("rotations", poses.rotations, FLOAT32, (count, self._joints, 4))
        check_array("world positions", out, FLOAT32, (count, self._joints, 3))
        flat = out.reshape(count, 3 * self._joints)
        world_kernels.world_positions(self._rig, poses.root_positions, poses.flat, flat)

    def pose(self, splice: Splice, time: float) -> Poses:
        """Returns one pose of a splice.

        Args:
            splice: The splice.
            time: Seconds into the locomotion.

        Raises:
            UnknownClipError: The bank has no such clip or hands, or the hands are not aligned to the clip that gives
                the upper body.
            TimeRangeError: `time` or `start` is NaN or outside its clip.
            SettingsError: Method or posture is unknown, or the posture of a splice with an action is `running`, which
                needs a memory.
        """
        out = Poses.empty(1, self._joints)
        if splice is not self._last and vars(splice) != vars(self._last):  # a fifth of the time that `==` takes
            self._one.records[0], self._last = self.record(splice), splice
        self._one.time[0] = time
        self._evaluate_one(self._one, out, None)
        return out

    def sequence(
        self, splice: Splice, times: NDArray[np.float64] | list[float], *, memory: Memory | None = None
    ) -> Poses:
        """Returns n poses of a splice, as one character plays them.

        Args:
            splice: The splice.
            times: [n] seconds into the locomotion, in order.
            memory: Memory of one character, advanced by n frames. Required for posture `running`.

        Raises:
            MotionError: For the same reasons as `pose`; SettingsError if `times` has another shape.
        """
        requests = self._at(splice, times)
        out = self.poses(len(requests))
        self._evaluate_one(requests, out, memory)
        return out

    def clip(self, splice: Splice) -> Clip:
        """Returns a whole splice as a clip, at the locomotion's own frames.

        Posture `running` is allowed: its memory begins with the first frame.

        Raises:
            MotionError: For the same reasons as `pose`.
        """
        rate = self.bank.clip(splice.locomotion).rate
        poses = self.sequence(splice, self.frame_times(splice.locomotion), memory=Memory.begin(1, rate))
        return poses.clip(splice.name, self.bank.skeleton, rate)

    def action_frames(self, splice: Splice, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Returns the time alignment curve [n]: the real-valued frame of the action that is played at each time.

        Frames past the action's last frame are in its seam (docs/bank.md).

        Args:
            splice: The splice.
            times: [n] seconds into the locomotion.

        Raises:
            MotionError: For the same reasons as `pose`.
        """
        requests = self._at(splice, times)
        frames = np.empty(len(requests))
        now = self._resolved(requests)[0]
        kernels.action_frames(self._handle, now.records, frames)
        stretch_kernels.frames_of_hybrids(self._handle, requests.records, now.records, frames)
        return frames

    def frame_times(self, locomotion: str) -> NDArray[np.float64]:
        """Returns the times [F], in seconds, of the F frames of a locomotion. Raises UnknownClipError."""
        clip = self.bank.clip(locomotion)
        return np.arange(clip.frame_count) / clip.rate

    def warm(self) -> None:
        """Compiles the kernels or loads them from the cache, so that later calls do not wait."""
        requests, poses = Requests.empty(1), self.poses(1)
        for memory in (None, Memory.begin(1, rate=60.0)):
            self.evaluate(requests, poses, memory)
        if self._threads > 1:
            self.evaluate(Requests.empty(2), self.poses(2))
        self.world_positions(poses, np.empty((1, self._joints, 3), np.float32))
        self.action_frames(Splice(self.bank.clips[0].name), np.zeros(1))

    def record(self, splice: Splice) -> tuple[int, int, float, float, int, int, int, int]:
        """Returns a splice as a record of Requests, at time 0. Raises UnknownClipError or SettingsError."""
        locomotion = self.bank.number(splice.locomotion)
        action = locomotion if splice.action is None else self.bank.number(splice.action)
        method = NONE if splice.action is None else known(METHODS, "method", splice.method)
        hands = 0
        if splice.hands is not None:
            hands, upper = 1 + self.bank.hand_number(splice.hands), locomotion if method == NONE else action
            if self.arrays.hand_rows[hands - 1, upper] < 0:
                raise self.bank.hands_not_aligned(splice.hands, self.bank.numbered[upper].name)
        return locomotion, action, 0.0, splice.start, 0, method, known(POSTURES, "posture", splice.posture), hands

    def _at(self, splice: Splice, times: NDArray[np.float64] | list[float]) -> Requests:
        """Returns requests for a splice at n times. Raises MotionError."""
        if len(shape := np.shape(times)) != 1:
            problem = f"times: expected a list or an array [n] of seconds, found one of shape {list(shape)}"
            raise SettingsError(problem, mend="Give a flat list, with one time for each pose")
        requests = Requests.empty(shape[0])
        requests.records[:] = self.record(splice)
        requests.time[:] = times
        return requests

    def _evaluate_one(self, requests: Requests, out: Poses, memory: Memory | None) -> None:
        """Evaluates requests about one character, into poses made for them; errors leave out the request's number."""
        if memory is not None:
            check_room(requests, out, memory, self._joints)
        try:
            self._evaluate_any(requests, out, memory)
        except TimeRangeError as error:
            raise TimeRangeError(error.problem, mend=error.mend) from None
