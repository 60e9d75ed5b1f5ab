"""The rig of a body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.stance import shown_by_motion, standing_pose
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class Rig:
    """A skeleton and the roles of its joints.

    pose: [J, 4] the standing pose, if a motion shows what the bind pose does not.
    """

    skeleton: Skeleton
    roles: Roles
    pose: Floats | None = None

    @classmethod
    def of(cls, clip: Clip, roles: Roles) -> Rig:
        """Returns the rig of a clip."""
        rig = clip.skeleton
        if not shown_by_motion(rig, roles):
            return cls(rig, roles)
        pose = standing_pose(rig, roles, clip)
        return cls(rig, roles, None if np.array_equal(pose, standing_pose(rig, roles)) else pose)

    def still(self) -> Clip:
        """Returns a clip of one frame in the bind pose."""
        rotations = np.tile(quaternion.IDENTITY, (1, self.skeleton.joint_count, 1))
        return Clip("bind pose", self.skeleton, 1.0, np.zeros((1, 3)), rotations)
