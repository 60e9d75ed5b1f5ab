"""The path of a clip: where its root would be without the sway and twist of single steps.

Position and heading of the path are means over one stride about each frame. The root relative to the path is the step
itself, which can be blended with another clip's step or played in place. Where a loop ends, the step equals the step
where the loop continues, so that the jump back is not visible.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.joint_paths import joint_paths
from motionsplice.precompute.preparation.seam import LEVEL

IN_PLACE = 0.5  # leg lengths: a clip without a gait whose root stays within this distance stands still
SOLE = 0.03  # leg lengths from the ground up to the lowest joint of a standing foot


def root_path(clip: Clip, phase: Floats, strides: int, roles: Roles, gait: bool) -> Floats:
    """Returns the path [rows, 4] of a clip with its seam: x, ground height and z in metres; heading in radians about Y.

    phase: [rows] cycles. strides: how far back the clip continues after its last row (0: it does not loop). gait:
    whether its phase is meaningful (`Alignment.has_gait`).
    """
    hips = joint_paths(clip, (roles.left_hip, roles.right_hip))
    root = np.column_stack([clip.root_positions, np.unwrap(heading(hips[:, 0] - hips[:, 1]))])
    if not gait and np.ptp(root[:, [0, 2]], axis=0).max() < IN_PLACE * roles.leg_length(clip.skeleton):
        return np.tile(root.mean(axis=0) * [1.0, 0.0, 1.0, 1.0], (len(root), 1))
    rows = np.arange(len(root))
    reach = min(round(0.5 * (len(root) - 1) / (phase[-1] - phase[0])), len(root) - 1)  # half a stride
    ahead = 2.0 * root[-1] - root[-2 : -2 - reach : -1]
    if strides:
        back = float(np.interp(phase[-1] - strides, phase, rows))
        ahead = _carried(_at(root, back + np.arange(reach + 1.0)), root[-1])[1:]
    padded = np.concatenate([2.0 * root[0] - root[reach:0:-1], root, ahead])
    path = uniform_filter1d(padded, 2 * reach + 1, axis=0)[reach : reach + len(root)]
    path[:, 1] = _ground(clip, roles, path[:, 1])
    if strides:
        ramp = np.clip(phase - (phase[-1] - 1.0), 0.0, 1.0)
        path += (ramp**2 * (3.0 - 2.0 * ramp))[:, None] * (_loop_end(_at(path, [back])[0], root, back) - path[-1])
    return path


def _at(rows: Floats, at: Floats | list[float]) -> Floats:
    """Returns `rows` [n, 4] interpolated at real-valued indices [m]."""
    return np.stack([np.interp(at, np.arange(len(rows)), column) for column in rows.T], axis=-1)


def _carried(path: Floats, start: Floats) -> Floats:
    """Returns a path [n, 4] turned about Y and moved so that it begins at `start` [4]."""
    turn = start[3] - path[0, 3]
    apart = path - path[0]
    x = np.cos(turn) * apart[:, 0] + np.sin(turn) * apart[:, 2]
    z = np.cos(turn) * apart[:, 2] - np.sin(turn) * apart[:, 0]
    return np.asarray(start + np.stack([x, apart[:, 1], z, apart[:, 3]], axis=-1))


def _loop_end(path: Floats, root: Floats, back: float) -> Floats:
    """Returns the end [4] of a path whose last step equals the step at row `back`, where the path is at `path` [4]."""
    return np.asarray(_carried(np.stack([_at(root, [back])[0], path]), root[-1])[1])


def _ground(clip: Clip, roles: Roles, height: Floats) -> Floats:
    """Returns the ground height [rows], metres, from the smoothed height [rows] of the root."""
    leg = roles.leg_length(clip.skeleton)
    if np.ptp(height) < LEVEL * leg:
        return np.zeros_like(height)
    lowest = joint_paths(clip, (*roles.feet[0], *roles.feet[1]))[..., 1].min(axis=1)
    return np.asarray(height - np.median(height - lowest) - SOLE * leg)
