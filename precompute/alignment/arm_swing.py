"""When the arms swing: a cue to the moment of the stride, beside the legs.

Legs alone time the upper body roughly. An arm that swings with the stride shows more exactly when a stride is early or
late. Each arm is compared with its own mean swing, at the phases of the legs, so it cannot shift a clip as a whole
against others. It counts as far as the stride explains it: an arm that carries or dribbles hardly does.
"""

from __future__ import annotations

import numpy as np

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.harmonics import fitted, waves

WEIGHT = 0.2  # leg lengths of root and knees that an arm's usual departure from its mean is worth
HARMONICS = 2  # of the stride in the mean swing
STILL = 0.02  # leg lengths: an arm that swings less counts less
STEADYING = 1e-3  # keeps coefficients that the clip's strides do not determine small


def arm_joints(roles: Roles) -> tuple[int, ...]:
    """Returns the joints that `arm_swing` needs."""
    hips, shoulders = (roles.left_hip, roles.right_hip), (roles.left_shoulder, roles.right_shoulder)
    return (*hips, *shoulders, roles.left_wrist, roles.right_wrist)


def arm_swing(positions: Floats) -> Floats:
    """Returns how far both wrists are in front of their shoulders [n, 2], metres.

    `positions` [n, 6, 3] are the world positions of the `arm_joints`, metres.
    """
    swing = np.empty((len(positions), 2))
    fill_swing(np.ascontiguousarray(positions), swing)
    return swing


@compiled(nogil=True, error_model="numpy")
def fill_swing(positions: Floats, swing: Floats) -> None:
    """Fills `swing` [n, 2]; see `arm_swing`. Ahead is across the hips, over the floor."""
    for frame in range(len(positions)):
        left, right = positions[frame, 0], positions[frame, 1]
        x, z = -(left[2] - right[2]), left[0] - right[0]
        size = np.sqrt(x * x + z * z)
        for arm in range(2):
            wrist, shoulder = positions[frame, 4 + arm], positions[frame, 2 + arm]
            swing[frame, arm] = (wrist[0] - shoulder[0]) * (x / size) + (wrist[2] - shoulder[2]) * (z / size)


def swing_distances(swing: Floats, phase: Floats, cells: int, leg: float) -> Floats:
    """Returns what the arms add to the distances of frames to the cells of a ring [n, cells], square metres.

    swing: [n, 2] of `arm_swing`. phase: [n] cycles, by the legs. leg: leg length, metres.
    """
    cycles = phase[-1] - phase[0]
    if cycles <= 1.0:  # nothing repeats
        return np.zeros((len(swing), cells))
    rows = waves(phase, HARMONICS)
    mean = fitted(swing, rows, STEADYING)
    motion = np.var(swing, axis=0) + (STILL * leg) ** 2
    explained = np.maximum(1.0 - np.mean((swing - rows @ mean) ** 2, axis=0) / motion, 0.0)
    trust = explained**2 * (1.0 - 1.0 / cycles)  # little repetition explains itself
    means, weights = waves(np.arange(cells) / cells, HARMONICS) @ mean, trust / motion
    left, right = (weights[arm] * (swing[:, arm, None] - means[:, arm]) ** 2 for arm in range(2))
    return np.asarray((WEIGHT * leg) ** 2 * (left + right))
