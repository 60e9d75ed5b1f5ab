"""The error of a splice taken apart: what it would be if one thing were known from the truth.

The gap between a number and the splice's own error shows what the splice lacks: another constant lag, another timing,
another turn of the torso, or other frames of the action altogether.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.quality.measures import over_root
from bench.quality.oracle import Laying, sampled_frames
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.best_rotations import best_rotations

LAGS = np.arange(-18, 19) / 60.0  # seconds
FASTEST = 4.0  # the most by which the best time may speed the action up


@dataclass(frozen=True)
class Dissection:
    """Mean errors that a splice would have, cm.

    lag: with the best constant lag of the action's time. lag_seconds: that lag; positive plays later frames.
    time: with the best time that never goes back, except where the splice itself goes back to repeat strides.
    torso: with the best turn of the whole upper body about the pelvis at each frame.
    oracle: with the best frames of the action, without regard to time order.
    """

    lag: float
    lag_seconds: float
    time: float
    torso: float
    oracle: float


def dissect(
    result: Clip,
    locomotion: Clip,
    action: Clip,
    truth: Clip,
    offsets: tuple[Floats, Floats],
    action_frames: Floats,
    own_frames: int,
    roles: Roles,
) -> Dissection:
    """Takes the error of a splice of posture `relative` apart.

    Args:
        result: The splice.
        locomotion, action, truth: Its sources, the action with its seam, and the truth.
        offsets: Torso offsets [F, 4] of locomotion and action at their frames.
        action_frames: [F] the action's frame at each frame of the result.
        own_frames: Number of the action's own frames, which come before its seam.
        roles: Which joint is which.
    """
    laying = Laying.of(locomotion, action, truth, offsets, roles)
    count = min(len(laying.goals), len(action_frames))
    frames = sampled_frames(count, locomotion.rate)
    played, last = action_frames[frames], action.frame_count - 1.0
    late = [float(laying.errors(frames, np.clip(played + lag * action.rate, 0.0, last)).mean()) for lag in LAGS]
    best = int(np.argmin(late))
    grid = laying.grid(frames, np.arange(action.frame_count))
    most = round(FASTEST * (frames[1] / locomotion.rate if len(frames) > 1 else 0.0) * action.rate)
    oracle = grid[:, sampled_frames(own_frames, action.rate)].min(axis=1).mean()
    return Dissection(
        lag=100.0 * late[best],
        lag_seconds=float(LAGS[best]),
        time=100.0 * best_time(grid, np.diff(played) < 0.0, most),
        torso=100.0 * _best_torso(result.frames(0, count), truth.frames(0, count), roles),
        oracle=100.0 * float(oracle),
    )


def best_time(grid: Floats, jumps: NDArray[np.bool_], most: int) -> float:
    """Returns the least mean of `grid` [n, m] over all paths that advance 0 to `most` columns per row.

    At a jump [n - 1] between two rows, a path may go on in any column.
    """
    total = grid[0]
    for row, jump in zip(grid[1:], jumps, strict=True):
        if jump:
            total = row + total.min()
        else:
            padded = np.concatenate([np.full(most, np.inf), total])
            total = row + np.lib.stride_tricks.sliding_window_view(padded, most + 1).min(axis=1)
    return float(total.min() / len(grid))


def _best_torso(result: Clip, truth: Clip, roles: Roles) -> float:
    """Returns the mean error in metres after the least-squares turn of the upper body about the pelvis."""
    at = joint_positions(result)
    pelvis = at[:, [roles.pelvis]] - at[:, :1]
    ours, goals = (over_root(clip, roles) - pelvis for clip in (result, truth))
    turned = quaternion.rotate(best_rotations(goals, ours)[:, None], ours)
    return float(np.linalg.norm(turned - goals, axis=-1).mean())
