"""Clips that are one whole cycle, as games loop them: how to recognise them and how to play them on.

A cycle of F frames ends with the pose that it begins with, so that its period is F - 1 frames, or it ends one frame
before that pose, so that its period is F frames.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.facing import facing, facing_joints
from motionsplice.precompute.body.joint_paths import joint_paths

STRIDES = (0.5, 1.8)  # seconds: the shortest and the longest stride
ALIKE = 0.25  # steps from frame to frame: the largest distance of two frames that show the same moment
MOST_GAP = 0.9  # steps: how far the first frame may be from where the last leads; 0.87 measured, at a heel strike
LONGEST_LEAP = 1.5  # of a joint's longest step: how far a single joint may be from where the last frame leads
LEAST_MOTION = 0.25  # of the mean step: a cycle is in motion at its ends, a jump or a punch at rest
LAPS = (-1, 0, 1, 2)  # give the clip's own lap, 0, and its seam a stride on both sides


def find_period(clip: Clip, roles: Roles) -> int | None:
    """Returns the period of a clip of F frames that is a whole cycle: F - 1 or F frames. None if it is not a cycle.

    In a cycle the last frame is like the first, or legs and joints move from the last frame to the first as they do
    from frame to frame on both sides.
    """
    count = clip.frame_count
    if count < 5 or not (STRIDES[0] <= count / clip.rate and clip.duration <= STRIDES[1]):
        return None
    clouds = facing(joint_paths(clip, facing_joints(roles)))
    legs = (clouds[:, 1:] - clouds[:, :1]).reshape(count, -1)
    turns, back = _turns(clip.rotations[:-1, 1:], clip.rotations[1:, 1:]), _turns(*clip.rotations[[-1, 0], 1:])
    motions = ((np.diff(legs, axis=0), legs[0] - legs[-1]), (turns, back))  # from frame to frame, from last to first
    if min(_size(steps) for steps, _ in motions) == 0.0:
        return None
    if max(_size(_between(steps)) / _size(steps) for steps, _ in motions) < LEAST_MOTION:
        return None
    gaps = [_size([_gap(steps, across, moved) for steps, across in motions]) for moved in (0.0, 1.0)]
    moved = int(gaps[0] > ALIKE and gaps[1] <= MOST_GAP)
    longest = np.maximum(quaternion.length(turns).max(axis=0), _size(turns))
    leaps = quaternion.length(back - moved * _between(turns)) / longest
    return count - 1 + moved if gaps[moved] <= MOST_GAP and leaps.max() <= LONGEST_LEAP else None


def _gap(steps: Floats, across: Floats, moved: float) -> float:
    """Returns the distance of `across`, the step from last to first, from `moved` times the expected step, in steps."""
    unit = max(_size(steps), _size(steps[0]), _size(steps[-1]))
    return _size(across - moved * _between(steps)) / unit


def played_on(clip: Clip, period: int, roles: Roles) -> Clip:
    """Returns the LAPS of a whole cycle as one clip, in which the clip itself begins at frame `period`.

    Root motion goes on from lap to lap, in the direction of the last frame.
    """
    turn, shift = _moved_on(clip, period, roles)
    positions, rotations = [], []
    cycle, start = clip.root_positions[:period], clip.root_positions[0]
    place = start - quaternion.rotate(_about_y(-turn), shift)
    for lap in LAPS:
        about = _about_y(lap * turn)
        positions.append(quaternion.rotate(about, cycle - start) + place)
        rotations.append(clip.rotations[:period].copy())
        rotations[-1][:, 0] = quaternion.multiply(about, rotations[-1][:, 0])
        place = place + quaternion.rotate(about, shift)
    return replace(clip, root_positions=np.concatenate(positions), rotations=np.concatenate(rotations))


def _moved_on(clip: Clip, period: int, roles: Roles) -> tuple[float, Floats]:
    """Returns how far the root turns about Y, radians, and moves [3], metres, in one cycle.

    Less than one step counts as zero, so that a cycle in place stays in place and a straight one stays straight.
    """
    hips = joint_paths(clip, (roles.left_hip, roles.right_hip))
    facings = np.unwrap(heading(hips[:, 0] - hips[:, 1]))
    turns = np.diff(facings)
    steps = quaternion.rotate(_about_y(-facings[:-1]), np.diff(clip.root_positions, axis=0))
    turn, shift = facings[-1] - facings[0], clip.root_positions[-1] - clip.root_positions[0]
    if period == clip.frame_count:
        turn, shift = turn + _between(turns), shift + quaternion.rotate(_about_y(facings[-1]), _between(steps))
    if np.hypot(shift[0], shift[2]) <= np.hypot(steps[:, 0], steps[:, 2]).max():
        shift = shift * [0.0, 1.0, 0.0]
    if abs(shift[1]) <= np.abs(steps[:, 1]).max():
        shift = shift * [1.0, 0.0, 1.0]
    return 0.0 if abs(turn) <= np.abs(turns).max() else float(turn), shift


def _between(steps: Floats) -> Floats:
    """Returns the expected step [...] from last frame to first: on a cubic through the two steps on either side."""
    return np.asarray((4.0 * (steps[-1] + steps[0]) - (steps[-2] + steps[1])) / 6.0)


def _turns(before: Floats, after: Floats) -> Floats:
    """Returns the rotation vectors [..., J, 3] from one pose [..., J, 4] to another, radians."""
    return quaternion.log(quaternion.multiply(quaternion.conjugate(before), after))


def _size(numbers: ArrayLike) -> float:
    """Returns the root mean square."""
    return float(np.sqrt(np.mean(np.square(numbers))))


def _about_y(radians: Floats | float) -> Floats:
    return quaternion.about([0.0, 1.0, 0.0], radians)
