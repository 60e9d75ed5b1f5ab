"""The evaluator: checks requests once, then lets the kernels write poses into the caller's arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motion.clip import Clip
from motion.errors import SettingsError, TimeRangeError
from runtime import kernels
from runtime.bank import Bank, ClipEntry
from runtime.requests import (
    METHODS,
    POSTURES,
    Float32s,
    Method,
    Poses,
    Posture,
    Requests,
    RunningPosture,
    known,
)

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
        self._check_room(requests, out)
        self._check(requests, running)
        kernels.evaluate(
            self._arrays,
            _columns(requests),
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

    def action_frames(
        self, locomotion: str, times: NDArray[np.float64], action: str, *, start: float = 0.0
    ) -> NDArray[np.float64]:
        """The time alignment curve: which frame of the action a splice shows at `times` [n] -> [n], real-valued.

        Frames past the action's last one lie in its seam (docs/bank.md). Raises as `pose` does.
        """
        requests, frames = Requests.empty(len(times)), np.empty(len(times))
        requests.locomotion[:], requests.action[:] = self.bank.number(locomotion), self.bank.number(action)
        requests.time[:], requests.start[:] = times, start
        self._check(requests, None)
        kernels.action_frames(self._arrays, _columns(requests), frames)
        return frames

    def frame_times(self, locomotion: str) -> NDArray[np.float64]:
        """The times, in seconds, of a locomotion's own frames."""
        clip = self.bank.clip(locomotion)
        return np.arange(clip.frame_count) / clip.rate

    def warm(self) -> None:
        """Compiles the kernels, or loads them compiled, so that no later call has to wait for it."""
        poses = self.pose(self.bank.clips[0].name, 0.0)
        self.world_positions(poses, np.empty((1, self.bank.skeleton.joint_count, 3), np.float32))

    def _check_room(self, requests: Requests, out: Poses) -> None:
        count = len(requests.time)
        columns = (requests.locomotion, requests.action, requests.start, requests.method, requests.posture)
        joints = self.bank.skeleton.joint_count
        fits = out.root_positions.shape == (count, 3) and out.rotations.shape == (count, joints, 4)
        if not fits or any(len(column) != count for column in columns):
            raise SettingsError("requests and poses have different numbers of characters or joints")

    def _check(self, requests: Requests, running: RunningPosture | None) -> None:
        count, clips = len(requests.time), len(self._durations)
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


def _columns(requests: Requests) -> kernels.RequestArrays:
    return kernels.RequestArrays(
        requests.locomotion, requests.time, requests.action, requests.start, requests.method, requests.posture
    )


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
        upper=np.array(upper[1:], np.int64),
        pelvis=roles.pelvis,
    )
