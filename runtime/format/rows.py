"""The rows of a bank: everything that a splice needs of one frame of a clip, contiguous in memory.

A splice reads the lower half of one clip and the upper half of another, so each half has a table. A row holds the root
position, the upper cloud and the rotations. Cloud and rotations are stored as planes: all x, all y and so on, each
padded to whole vectors (docs/bank.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.hand_joints import elbow_of, has_fingers
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import SIDES, Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.simd.width import LANES

Float32s = NDArray[np.float32]

ROOT, SIZE, CLOUD = 0, 3, 4  # first columns
PELVIS, POSTURE_FRAME, TORSO_OFFSET, FIRST_JOINT = 0, 1, 2, 3  # lanes
USAGE = 4  # floats of `upper` before the first plane, one for each part of an upper body
LINE = 16  # floats in a cache line


class TorsoRows(NamedTuple):
    """How the upper body sits on the root in n frames (docs/bank.md).

    Attributes:
        clouds: [n, points, 3] metres, the upper cloud in the pelvis's frame.
        frames: [n, 4] xyzw, the posture frame relative to the pelvis's parent.
        offsets: [n, 4] xyzw, the turn, in the posture frame, from the neutral's torso at this phase to the clip's own.
    """

    clouds: Floats
    frames: Floats
    offsets: Floats


@dataclass(frozen=True)
class Half:
    """The columns of a table of rotations: its joints, the lane of the first one, the column of the first plane."""

    joints: tuple[int, ...]
    first_plane: int
    first_joint: int = FIRST_JOINT

    @property
    def width(self) -> int:
        """Number of lanes of a plane."""
        return _whole(self.first_joint + len(self.joints), LANES)

    @property
    def columns(self) -> int:
        """Number of floats in a row."""
        return _whole(self.first_plane + 4 * self.width, LINE)

    def lanes(self, rows: NDArray[np.float32]) -> Float32s:
        """Returns the rotations [n, width, 4] in rows [n, columns], as a view."""
        planes = rows[:, self.first_plane : self.first_plane + 4 * self.width]
        return np.moveaxis(planes.reshape(len(rows), 4, self.width), 1, 2)


@dataclass(frozen=True)
class Layout:
    """The columns of all tables of rotations.

    Attributes:
        lower: The joints that are not below the pelvis, which has a lane of its own.
        upper: The joints below the pelvis, which has a lane of its own.
        hands: The part of the upper half that a hands clip can drive: all joints from the elbows on if the rig has
            fingers, else none.
        pelvis: The pelvis joint.
        points: Number of points of the upper cloud.
    """

    lower: Half
    upper: Half
    hands: Half
    pelvis: int
    points: int

    @classmethod
    @lru_cache(maxsize=16)
    def of(cls, skeleton: Skeleton, roles: Roles) -> Layout:
        above, points = skeleton.subtree(roles.pelvis), len(roles.upper_cloud)
        below = tuple(joint for joint in range(skeleton.joint_count) if joint not in above)
        first_plane = _whole(CLOUD + 3 * _whole(points, LANES), LANES)
        upper = tuple(joint for joint in above if joint != roles.pelvis)
        driven = {one for side in SIDES for one in skeleton.subtree(elbow_of(roles, side))}
        hands = tuple(one for one in upper if one in driven) if has_fingers(skeleton, roles) else ()
        return cls(Half(below, first_plane), Half(upper, first_plane), Half(hands, 0, 0), roles.pelvis, points)

    @property
    def cloud_width(self) -> int:
        """Number of lanes of a plane of the cloud."""
        return _whole(self.points, LANES)

    @property
    def halves(self) -> dict[str, Half]:
        """The two halves by name of table."""
        return {"lower": self.lower, "upper": self.upper}

    def set_torso_offsets(self, half: str, rows: Float32s, offsets: Floats) -> None:
        """Writes torso offsets [n, 4] into rows [n, columns] of a table."""
        self.halves[half].lanes(rows)[:, TORSO_OFFSET] = offsets

    def set_usage(self, rows: Float32s, usage: Floats) -> None:
        """Writes usage weights [n, PARTS] into rows [n, columns] of the table `upper`."""
        rows[:, self.upper.first_plane - USAGE : self.upper.first_plane] = usage

    def usage(self, rows: Float32s) -> Floats:
        """Returns the usage weights [n, PARTS] in rows [n, columns] of the table `upper`."""
        return rows[:, self.upper.first_plane - USAGE : self.upper.first_plane].astype(np.float64)

    def stance(self, row: Float32s, rotations: Floats) -> Floats:
        """Returns `rotations` [J, 4] with those of the upper body from a row [columns] of the table `stances`."""
        posed, lanes = rotations.copy(), self.upper.lanes(row[None])[0]
        posed[list(self.upper.joints)] = lanes[FIRST_JOINT : FIRST_JOINT + len(self.upper.joints)]
        posed[self.pelvis] = lanes[PELVIS]
        return posed

    def pack_hands(self, rotations: Floats) -> Float32s:
        """Returns the rows [n, columns] of the table `hands` for rotations [n, J, 4]."""
        rows = np.zeros((len(rotations), self.hands.columns), np.float32)
        lanes = self.hands.lanes(rows)
        lanes[:] = quaternion.IDENTITY
        lanes[:, : len(self.hands.joints)] = rotations[:, self.hands.joints]
        return rows

    def motion(self, lower: Float32s, upper: Float32s) -> tuple[Floats, Floats]:
        """Returns root positions [n, 3] and rotations [n, J, 4] from the rows of n frames in both tables."""
        rotations = np.empty((len(lower), len(self.lower.joints) + len(self.upper.joints) + 1, 4))
        for half, rows in ((self.lower, lower), (self.upper, upper)):
            rotations[:, half.joints] = half.lanes(rows)[:, FIRST_JOINT : FIRST_JOINT + len(half.joints)]
        rotations[:, self.pelvis] = self.lower.lanes(lower)[:, PELVIS]
        return lower[:, ROOT : ROOT + 3].astype(np.float64), rotations

    def torso(self, lower: Float32s) -> TorsoRows:
        """Returns the torso data in rows of the table `lower`."""
        lanes = self.lower.lanes(lower).astype(np.float64)
        return TorsoRows(self._clouds(lower).astype(np.float64), lanes[:, POSTURE_FRAME], lanes[:, TORSO_OFFSET])

    def _clouds(self, rows: Float32s) -> Float32s:
        """Returns the clouds [n, points, 3] in rows of either table, as a view."""
        planes = rows[:, CLOUD : CLOUD + 3 * self.cloud_width].reshape(len(rows), 3, self.cloud_width)
        return np.moveaxis(planes, 1, 2)[:, : self.points]


def _whole(count: int, of: int) -> int:
    """Returns `count` rounded up to a multiple of `of`."""
    return -(-count // of) * of
