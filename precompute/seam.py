"""Going on past a clip's end: frames that lead from its last one back to a whole number of strides before.

Every clip with a gait can be repeated by whole strides, but no two strides are quite alike. So a few frames are added:
those that followed the last one's counterpart, bent so that they continue the clip's end in pose and velocity, and
straightened within the seam. The clip's own frames stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from motion import quaternion
from motion.clip import Clip
from motion.kinematics import hips_heading, joint_positions
from motion.quaternion import Floats
from motion.roles import Roles

SEAM = 0.3  # seconds
WIDEST_GAP = 0.5  # radians, root-mean-square over joints, from the last frame to its counterpart
WIDEST_TURN = 1.2  # radians, of any one joint
ABOUT_AS_GOOD = 1.25  # of the least gap: of such loops the longest is taken


@dataclass(frozen=True, eq=False)
class Seamed:
    """A clip's own frames and then the seam's [rows], their phase [rows], and the strides to go back at its end.

    Without a usable loop there is no seam, and strides is 0.
    """

    clip: Clip
    phase: Floats
    strides: int


def add_seam(clip: Clip, phase: Floats, roles: Roles) -> Seamed:
    """Adds a seam to a clip whose `phase` [F] is known; root motion goes on in the direction of the last frame."""
    last, count = clip.frame_count - 1, max(2, round(SEAM * clip.rate))
    gaps: dict[int, float] = {}
    for strides in range(1, int(phase[-1] - phase[0]) + 1):
        counterpart = float(np.interp(phase[-1] - strides, phase, np.arange(last + 1)))
        if 1.0 <= counterpart <= last - count:
            there = clip.sampled([counterpart])[1][0, 1:]
            turns = quaternion.angle(there, clip.rotations[last, 1:])
            if turns.max() <= WIDEST_TURN:
                gaps[strides] = float(np.sqrt(np.mean(turns**2)))
    if not gaps or min(gaps.values()) > WIDEST_GAP:
        return Seamed(clip, phase, 0)
    strides = max(number for number, gap in gaps.items() if gap <= ABOUT_AS_GOOD * min(gaps.values()))
    counterpart = float(np.interp(phase[-1] - strides, phase, np.arange(last + 1)))
    after = counterpart + np.arange(1.0, count + 1.0)
    positions, rotations = _carried_on(clip, counterpart, after, roles)
    longer = replace(
        clip,
        root_positions=np.concatenate([clip.root_positions, positions]),
        rotations=np.concatenate([clip.rotations, rotations]),
    )
    return Seamed(longer, np.concatenate([phase, np.interp(after, np.arange(last + 1), phase) + strides]), strides)


def _carried_on(clip: Clip, counterpart: float, after: Floats, roles: Roles) -> tuple[Floats, Floats]:
    """Root positions and rotations of the frames `after` the counterpart, moved to the clip's end and bent onto it."""
    positions, rotations = clip.sampled(np.concatenate([[counterpart - 1.0, counterpart], after]))
    ends = clip.frames(clip.frame_count - 2, clip.frame_count)
    turn = quaternion.about([0.0, 1.0, 0.0], _heading(ends, roles) - _heading(_one(clip, counterpart), roles))
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    positions = quaternion.rotate(turn, positions - positions[1]) + ends.root_positions[1]
    positions[:, 1] += clip.sampled([counterpart])[0][0, 1] - ends.root_positions[1, 1]
    offset = quaternion.multiply(quaternion.conjugate(rotations[:2]), ends.rotations)
    bend = Rotation.from_quat(offset.reshape(-1, 4)).as_rotvec().reshape((*offset.shape[:-1], 3))
    rise = (ends.root_positions - positions[:2])[:, 1]
    unbent, unrisen = _settled(bend, len(after)), _settled(rise, len(after))
    positions[2:, 1] += unrisen
    back = Rotation.from_rotvec(unbent.reshape(-1, 3)).as_quat().reshape((*unbent.shape[:-1], 4))
    return positions[2:], quaternion.multiply(rotations[2:], back)


def _settled(offset: Floats, count: int) -> Floats:
    """An offset known at two frames in a row [2, ...], let go to zero smoothly over the next `count` frames."""
    velocity = offset[1] - offset[0]
    t = (np.arange(1.0, count + 1.0) / count).reshape((-1, *[1] * (offset.ndim - 1)))
    return (2.0 * t**3 - 3.0 * t**2 + 1.0) * offset[1] + (t**3 - 2.0 * t**2 + t) * count * velocity


def _one(clip: Clip, frame: float) -> Clip:
    positions, rotations = clip.sampled([frame])
    return replace(clip, root_positions=positions, rotations=rotations)


def _heading(clip: Clip, roles: Roles) -> float:
    """The direction of the hips in a clip's last frame, radians about Y."""
    return float(hips_heading(joint_positions(clip)[-1], roles))
