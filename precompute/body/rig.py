"""The rig of a body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class Rig:
    """A skeleton and the roles of its joints. A bank has the rig of its baseline's file."""

    skeleton: Skeleton
    roles: Roles

    def still(self) -> Clip:
        """Returns a clip of one frame in the bind pose."""
        rotations = np.tile(quaternion.IDENTITY, (1, self.skeleton.joint_count, 1))
        return Clip("bind pose", self.skeleton, 1.0, np.zeros((1, 3)), rotations)
