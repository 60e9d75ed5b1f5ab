"""The evaluator: checks requests once, then lets the kernels write poses into the caller's arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motion.clip import Clip
from motion.errors import SettingsError, TimeRangeError, did_you_mean
from runtime import kernels
from runtime.bank import Bank, ClipEntry

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


NO_MEMORY = kernels.PostureArrays(np.empty((0, 2, 3)), 0.0)


class Evaluator:
    """Evaluates splices of a bank's clips in constant time per character (Heck's thesis, 4.3).

    Not to be shared between threads: each makes its own, over the same bank.
    """

    def __init__(self, bank: Bank) -> None:
        self.bank = bank
        self._arrays = _bank_arrays(bank)
        self._durations = np.array([clip.duration for clip in bank.clips])
        joints = bank.skeleton.joint_count
        self._scratch = kernels.Scratch(np.empty(4), np.empty(4), np.empty(4), np.empty(4), np.empty((3, 3)))
        self._world = np.empty((joints, 4))

    def poses(self, count: int) -> Poses:
        """Room for the poses of `count` characters."""
        joints = self.bank.skeleton.joint_count
        return Poses(np.empty((count, 3), np.float32), np.empty((count, joints, 4), np.float32))

    def evaluate(self, requests: Requests, out: Poses, running: RunningPosture | None = None) -> None:
        """Writes every character's pose into `out`, which has as many rows as `requests`.

        Posture `running` needs `running`, which each call carries on by one frame. Raises TimeRangeError, naming the
        first character at fault, if a time or start is not a number or lies outside its clip; SettingsError if a clip,
        method or posture number is unknown or sizes differ.
        """
        self._check(requests, out, running)
        kernels.evaluate(
            self._arrays,
            kernels.RequestArrays(
                requests.locomotion,
                requests.time,
                requests.action,
                requests.start,
                requests.method,
                requests.posture,
            ),
            kernels.PostureArrays(running.means, running.share) if running else NO_MEMORY,
            self._scratch,
            out.root_positions,
            out.rotations,
        )

    def world_positions(self, poses: Poses, out: Float32s) -> None:
        """Writes world positions [n, J, 3], metres, of evaluated poses into `out`."""
        kernels.world_positions(self._arrays, poses.root_positions, poses.rotations, self._world, out)

    def pose(
        self,
        locomotion: str,
        time: float,
        action: str | None = None,
        *,
        start: float = 0.0,
        method: Method = "splice",
        posture: Posture = "relative",
    ) -> Poses:
        """One character's pose, by name. Without an action it is the locomotion alone.

        Raises UnknownClipError, TimeRangeError or SettingsError.
        """
        return self.sequence(locomotion, [time], action, start=start, method=method, posture=posture)

    def sequence(
        self,
        locomotion: str,
        times: NDArray[np.float64] | list[float],
        action: str | None = None,
        *,
        start: float = 0.0,
        method: Method = "splice",
        posture: Posture = "relative",
        running: RunningPosture | None = None,
    ) -> Poses:
        """The poses of one splice at many times [n], seconds into the locomotion. Raises as `pose` does.

        With `running`, of one character, they are evaluated one after the other, and it is carried on to the last.
        """
        requests, out = Requests.empty(len(times)), self.poses(len(times))
        requests.locomotion[:] = self.bank.number(locomotion)
        requests.action[:] = self.bank.number(locomotion if action is None else action)
        requests.time[:] = times
        requests.start[:] = start
        requests.method[:] = kernels.NONE if action is None else known(METHODS, "method", method)
        requests.posture[:] = known(POSTURES, "posture", posture)
        try:
            if running is None:
                self.evaluate(requests, out)
            else:
                for row in range(len(times)):
                    self.evaluate(requests.rows(row, row + 1), out.rows(row, row + 1), running)
        except TimeRangeError as error:  # there is one character here, whose number says nothing
            raise TimeRangeError(error.problem, mend=error.mend) from None
        return out

    def clip(
        self,
        locomotion: str,
        action: str | None = None,
        *,
        start: float = 0.0,
        method: Method = "splice",
        posture: Posture = "relative",
    ) -> Clip:
        """A whole splice, at the locomotion's own frames, as a clip. Raises as `pose` does."""
        times, rate = self.frame_times(locomotion), self.bank.clip(locomotion).rate
        running = RunningPosture.begin(1, rate) if posture == "running" else None
        poses = self.sequence(locomotion, times, action, start=start, method=method, posture=posture, running=running)
        return Clip(
            name=locomotion if action is None else f"{locomotion}+{action}",
            skeleton=self.bank.skeleton,
            rate=rate,
            root_positions=poses.root_positions.astype(np.float64),
            rotations=poses.rotations.astype(np.float64),
        )

    def frame_times(self, locomotion: str) -> NDArray[np.float64]:
        """The times, in seconds, of a locomotion's own frames."""
        clip = self.bank.clip(locomotion)
        return np.arange(clip.frame_count) / clip.rate

    def warm(self) -> None:
        """Compiles the kernels, or loads them compiled, so that no later call has to wait for it."""
        poses = self.pose(self.bank.clips[0].name, 0.0)
        self.world_positions(poses, np.empty((1, self.bank.skeleton.joint_count, 3), np.float32))

    def _check(self, requests: Requests, out: Poses, running: RunningPosture | None) -> None:
        count, clips = len(requests.time), len(self._durations)
        columns = (requests.locomotion, requests.action, requests.start, requests.method, requests.posture)
        joints = self.bank.skeleton.joint_count
        fits = out.root_positions.shape == (count, 3) and out.rotations.shape == (count, joints, 4)
        if not fits or any(len(column) != count for column in columns):
            raise SettingsError("requests and poses have different numbers of characters or joints")
        if count == 0:
            return
        for label, numbers, top in (
            ("locomotion", requests.locomotion, clips),
            ("action", requests.action, clips),
            ("method", requests.method, len(METHODS)),
            ("posture", requests.posture, len(POSTURES)),
        ):
            if numbers.min() < 0 or numbers.max() >= top:
                raise SettingsError(f"a {label} number lies outside 0 to {top - 1}")
        follows = np.any((requests.posture == kernels.RUNNING) & (requests.method == kernels.SPLICE))
        if follows and (running is None or running.means.shape != (count, 2, 3)):
            raise SettingsError(
                "posture 'running' is a mean over the frames so far, and none are given",
                mend="Evaluate frame after frame with a RunningPosture of as many characters, or ask for a whole clip",
            )
        self._check_times("time", requests.time, requests.locomotion)
        self._check_times("start", requests.start, requests.action)

    def _check_times(self, label: str, seconds: NDArray[np.float64], clips: NDArray[np.int32]) -> None:
        inside = (seconds >= 0.0) & (seconds <= self._durations[clips] + 1e-6)  # false for NaN
        if inside.all():
            return
        character = int(np.argmin(inside))
        clip: ClipEntry = self.bank.clips[clips[character]]
        raise TimeRangeError(
            f"{label} {seconds[character]} s lies outside clip {clip.name!r}, which lasts {clip.duration:.3f} s",
            place=f"character {character}" if len(seconds) > 1 else "",
            mend=f"Give a {label} from 0 to {clip.duration:.3f}",
        )


def known(constants: Mapping[str, int], label: str, name: str) -> int:
    """The kernel constant of a method or posture; raises SettingsError if there is none of that name."""
    try:
        return constants[name]
    except KeyError:
        raise SettingsError(f"there is no {label} {name!r}", mend=did_you_mean(name, constants)) from None


def _bank_arrays(bank: Bank) -> kernels.BankArrays:
    tables, clips, roles = bank.tables, bank.clips, bank.roles
    upper = bank.skeleton.subtree(roles.pelvis)
    lower = [joint for joint in range(bank.skeleton.joint_count) if joint not in set(upper)]
    return kernels.BankArrays(
        **{name: tables[name] for name in ("rotations", "root_positions", "phase_of_frame", "frame_of_phase")},
        **{name: tables[name] for name in ("upper_clouds", "posture_frames", "torso_offsets", "postures")},
        first_row=np.array([clip.first_row for clip in clips]),
        frame_count=np.array([clip.frame_count for clip in clips]),
        row_count=np.array([clip.row_count for clip in clips]),
        rate=np.array([clip.rate for clip in clips]),
        first_cell=np.array([clip.first_cell for clip in clips]),
        cell_count=np.array([clip.cell_count for clip in clips]),
        first_phase=np.array([clip.first_phase for clip in clips]),
        last_phase=np.array([clip.last_phase for clip in clips]),
        loop=np.array([clip.loop for clip in clips]),
        parents=bank.skeleton.parents,
        offsets=bank.skeleton.offsets,
        lower=np.array(lower),
        upper=np.array([joint for joint in upper if joint != roles.pelvis], np.int64),
        pelvis=roles.pelvis,
    )
