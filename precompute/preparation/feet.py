"""The standing foot drives the root: steps of the root that keep a foot in place while the pose over it is bent."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.joint_paths import joint_paths
from motionsplice.precompute.body.turned_points import turned_points

LOOSE, FIRM = 0.4, 0.6  # support below which a foot is free, and from which on it holds the root
TINY = 1e-12


def feet_over_ground(clip: Clip, roles: Roles) -> Floats:
    """Returns the positions [F, 2, 2] of both feet over the ground, x and z in metres: of the toes if the rig has them,
    else of the ankles."""
    return joint_paths(clip, [joints[-1] for joints in roles.feet])[..., [0, 2]]


def standing_feet(clip: Clip, path: Floats, support: Floats, roles: Roles) -> Floats:
    """Returns the rows [F, 6] of the table `feet`: for the left, then the right foot, x and z in metres from the root
    path [F, 4], in its heading, and its `support` [F, 2].
    """
    back = quaternion.about([0.0, 1.0, 0.0], -path[:, 3])
    apart = joint_paths(clip, [joints[-1] for joints in roles.feet]) - path[:, None, :3]
    return np.concatenate([turned_points(back, apart)[..., [0, 2]], support[..., None]], axis=2).reshape(-1, 6)


def root_steps(slips: Floats, support: Floats, preferred: ArrayLike = (1.0, 1.0)) -> Floats:
    """Returns the steps [F, 2] of the root against the slips [F, 2, 2] of both feet, which stand by `support` [F, 2].

    A foot that stands alone does not slip. Of two, the firmer counts more; `preferred` [2] are factors of both feet.
    """
    held = np.clip((support - LOOSE) / (FIRM - LOOSE), 0.0, 1.0)
    firmness = held**2 * (3.0 - 2.0 * held)
    weights = firmness**2 * np.asarray(preferred)
    weights /= np.maximum(np.sum(weights, axis=1, keepdims=True), TINY)
    return np.asarray(-firmness.max(axis=1, keepdims=True) * np.sum(weights[..., None] * slips, axis=1))
