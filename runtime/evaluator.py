"""The evaluator: checks requests once, then lets the kernels write poses into the caller's arrays."""

from __future__ import annotations

from threading import Lock
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError, TimeRangeError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels import evaluate as kernels
from motionsplice.runtime.kernels import world as world_kernels
from motionsplice.runtime.kernels.lookup import NONE
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
    time_fault,
)
from motionsplice.runtime.splice import Splice

NO_MEMORY = Memory(np.empty((0, arrays.MEMORY_COLUMNS)), 0.0)
ONE_AT_A_TIME = Lock()  # not every threading layer of numba's bears two parallel calls at once


class Evaluator:
    """Evaluates splices of a bank's clips in constant time per character (Heck's thesis, 4.3).

    With `threads`, batches are divided among so many. Not to be shared between threads: each makes its own, over the
    same bank.
    """

    def __init__(self, bank: Bank, *, threads: int = 1) -> None:
        most = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
        if not 1 <= threads <= most:
            raise SettingsError(f"{threads} threads cannot be had", mend=f"Ask for 1 to {most}")
        self.bank = bank
        self._threads = threads
        self._joints = bank.skeleton.joint_count
        self.arrays = arrays.bank_arrays(bank)
        self._rig = arrays.rig_arrays(bank.skeleton)
        self.scratch = arrays.scratch(self.arrays, threads)
        self._world = world_kernels.scratch(bank.skeleton.joint_count)
        self._one = Requests.empty(1)

    def poses(self, count: int) -> Poses:
        """Room for the poses of `count` characters."""
        return Poses.empty(count, self._joints)

    def evaluate(self, requests: Requests, out: Poses, memory: Memory | None = None) -> None:
        """Writes every character's pose into `out`, which has as many rows as `requests`.

        Posture `running` needs `memory`, which each call carries on by one frame; a memory of one character takes all
        requests for that one's, in order. Raises TimeRangeError, naming the first character at fault, if a time or
        start is not a number or lies outside its clip; SettingsError if a clip, method or posture number is unknown or
        sizes differ.
        """
        self._check_room(requests, out, memory)
        remembered = memory or NO_MEMORY
        work = (self.arrays, requests.records, remembered.state, remembered.share, self.scratch)
        if self._threads == 1 or len(remembered.state) == 1:
            fault = kernels.evaluate(*work, out.root_positions, out.flat)
        else:
            with ONE_AT_A_TIME:
                numba.set_num_threads(self._threads)
                fault = kernels.evaluate_in_parallel(*work, out.root_positions, out.flat)
        if fault >= 0:
            raise self._fault(requests, fault)

    def world_positions(self, poses: Poses, out: Float32s) -> None:
        """Writes world positions [n, J, 3], metres, of evaluated poses into `out`. Raises SettingsError."""
        count = len(poses.flat)
        check_array("rotations", poses.rotations, FLOAT32, (count, self._joints, 4))
        check_array("world positions", out, FLOAT32, (count, self._joints, 3))
        flat = out.reshape(count, 3 * self._joints)
        world_kernels.world_positions(self._rig, poses.root_positions, poses.flat, self._world, flat)

    def pose(self, splice: Splice, time: float) -> Poses:
        """The pose of one character `time` seconds into the locomotion.

        Raises UnknownClipError, also for hands that are not aligned to the clip that gives the upper body;
        TimeRangeError; or SettingsError.
        """
        out = self.poses(1)
        self._one.records[0] = self.record(splice)
        self._one.time[0] = time
        self._evaluate_one(self._one, out, None)
        return out

    def sequence(
        self, splice: Splice, times: NDArray[np.float64] | list[float], *, memory: Memory | None = None
    ) -> Poses:
        """The poses of one character at `times` [n], in order, seconds into the locomotion.

        A memory of one character is carried on to the last of them. Raises as `pose` does.
        """
        requests, out = Requests.empty(len(times)), self.poses(len(times))
        requests.records[:] = self.record(splice)
        requests.time[:] = times
        self._evaluate_one(requests, out, memory)
        return out

    def clip(self, splice: Splice) -> Clip:
        """The whole splice at the locomotion's own frames, as a clip. Raises as `pose` does."""
        rate = self.bank.clip(splice.locomotion).rate
        poses = self.sequence(splice, self.frame_times(splice.locomotion), memory=Memory.begin(1, rate))
        return Clip(
            name=splice.name,
            skeleton=self.bank.skeleton,
            rate=rate,
            root_positions=poses.root_positions.astype(np.float64),
            rotations=poses.rotations.astype(np.float64),
        )

    def action_frames(self, splice: Splice, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """The time alignment curve: the real-valued frame of the action that is played at `times` [n] -> [n].

        Frames past the action's last one lie in its seam (docs/bank.md). Raises as `pose` does.
        """
        requests, frames = Requests.empty(len(times)), np.empty(len(times))
        requests.records[:] = self.record(splice)
        requests.time[:] = times
        if (fault := kernels.first_at_fault(self.arrays, requests.records, True)) >= 0:
            raise self._fault(requests, fault)
        kernels.action_frames(self.arrays, requests.records, frames)
        return frames

    def frame_times(self, locomotion: str) -> NDArray[np.float64]:
        """The times, in seconds, of a locomotion's own frames."""
        clip = self.bank.clip(locomotion)
        return np.arange(clip.frame_count) / clip.rate

    def warm(self) -> None:
        """Compiles the kernels, or loads them compiled, so that no later call has to wait for it."""
        requests, joints = Requests.empty(1), self.bank.skeleton.joint_count
        poses = self.poses(1)
        for memory in (None, Memory.begin(1, rate=60.0)):
            self.evaluate(requests, poses, memory)
        if self._threads > 1:
            self.evaluate(Requests.empty(2), self.poses(2))
        self.world_positions(poses, np.empty((1, joints, 3), np.float32))

    def record(self, splice: Splice) -> tuple[int, int, float, float, int, int, int, int]:
        """The splice as a record of Requests, at time 0. Raises UnknownClipError or SettingsError."""
        locomotion = self.bank.number(splice.locomotion)
        action = locomotion if splice.action is None else self.bank.number(splice.action)
        method = NONE if splice.action is None else known(METHODS, "method", splice.method)
        hands = 0
        if splice.hands is not None:
            hands, upper = 1 + self.bank.hand_number(splice.hands), locomotion if method == NONE else action
            if self.arrays.hand_rows[hands - 1, upper] < 0:
                raise self.bank.hands_not_aligned(splice.hands, self.bank.clips[upper].name)
        return locomotion, action, 0.0, splice.start, 0, method, known(POSTURES, "posture", splice.posture), hands

    def _evaluate_one(self, requests: Requests, out: Poses, memory: Memory | None) -> None:
        """As `evaluate`, for requests about one character, whose number says nothing in an error."""
        try:
            self.evaluate(requests, out, memory)
        except TimeRangeError as error:
            raise TimeRangeError(error.problem, mend=error.mend) from None

    def _check_room(self, requests: Requests, out: Poses, memory: Memory | None) -> None:
        count = len(requests.records)
        if out.flat.shape != (count, 4 * self._joints):
            problem = (
                f"there are {count} requests, and room for {len(out.flat)} poses of {out.rotations.shape[1]} joints"
            )
            raise SettingsError(problem, mend="Evaluator.poses makes room for as many characters as there are requests")
        if memory is not None and len(memory.state) not in (1, count):
            raise SettingsError(
                f"there are {count} requests, and a memory of {len(memory.state)} characters",
                mend="Give a Memory of as many characters, or of the one that all requests are about",
            )

    def _fault(self, requests: Requests, character: int) -> SettingsError | TimeRangeError:
        """What is wrong with a request, as an error."""
        request, clips = requests.records[character], self.bank.clips
        place = f"character {character}" if len(requests.records) > 1 else ""
        for label, number, top in (
            ("locomotion", request["locomotion"], len(clips)),
            ("action", request["action"], len(clips)),
            ("method", request["method"], len(METHODS)),
            ("posture", request["posture"], len(POSTURES)),
        ):
            if not 0 <= number < top:
                return SettingsError(f"{label} number {number} lies outside 0 to {top - 1}", place=place)
        if (hands_fault := self._fault_of_hands(request, place)) is not None:
            return hands_fault
        for label, clip in (("time", clips[request["locomotion"]]), ("start", clips[request["action"]])):
            if (fault := time_fault(label, float(request[label]), clip, place)) is not None:
                return fault
        return SettingsError(
            "posture 'running' is a mean over the frames so far, and there is no memory of them",
            place=place,
            mend="Evaluate frame after frame with a Memory, or ask for a whole clip",
        )

    def _fault_of_hands(self, request: Any, place: str) -> SettingsError | None:
        """What is wrong with the hands of a request, if anything is."""
        hands, count = int(request["hands"]) - 1, len(self.bank.hand_clips)
        if hands >= count:
            return SettingsError(f"hands number {hands + 1} lies outside 0 to {count}", place=place)
        upper = self.bank.clips[request["locomotion" if request["method"] == NONE else "action"]].name
        if hands >= 0 and self.arrays.hand_rows[hands, self.bank.number(upper)] < 0:
            hands_fault = self.bank.hands_not_aligned(self.bank.hand_clips[hands], upper)
            return SettingsError(hands_fault.problem, place=place, mend=hands_fault.mend)
        return None
