"""How far the legs of two motions are apart, and moments of a motion to compare."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from motionsplice.motion.clip import Clip
from motionsplice.motion.pointcloud import level, planar_distance
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles


def legs_apart(one: Floats, other: Floats, roles: Roles) -> Floats:
    """Returns the distance of root and knees at each frame [F], root mean square, from places of joints [F, J, 3].

    Both are in metres.
    """
    cloud = list(roles.lower_cloud)
    return np.sqrt(planar_distance(*(level(at[:, cloud]) for at in (one, other))) / len(cloud))


def at_frames(clip: Clip, frames: ArrayLike) -> Clip:
    """Returns a clip of its real-valued `frames` [n] alone."""
    positions, rotations = clip.sampled(frames)
    return replace(clip, root_positions=positions, rotations=rotations)
