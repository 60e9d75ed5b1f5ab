"""The constant rotations between the standing poses of two rigs.

Limbs, hands and fingers shall point as theirs do. Trunk, neck, head, collars and feet shall be turned as far from their
own standing pose as theirs are: both stand upright there with flat feet, although their joints lie elsewhere in the
body.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.hand_joints import palm_of
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.segments import Segment, segments_of
from motionsplice.motion.retarget.stance import UP, ahead, frame, heading
from motionsplice.motion.roles import SIDES, Roles, Side
from motionsplice.motion.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class Standing:
    """A rig and the world rotations [J, 4] of its joints in its standing pose."""

    skeleton: Skeleton
    roles: Roles
    pose: Floats

    @cached_property
    def segments(self) -> dict[str, Segment]:
        """The rig's segments by name."""
        return segments_of(self.skeleton, self.roles)

    def bone(self, name: str) -> Floats:
        """Returns the vector [3] from the start of a segment to its end, in the standing pose."""
        segment = self.segments[name]
        return quaternion.rotate(self.pose[segment.joints[0]], segment.bone)

    def ahead(self, joint: int) -> Floats:
        """Returns the mean vector [3] from a joint to its children, or else to its end sites."""
        return quaternion.rotate(self.pose[joint], ahead(self.skeleton, joint))


def bind_turns(theirs: Standing, ours: Standing) -> dict[str, Floats]:
    """Returns, for each segment that both rigs have, the rotations [n, 4] between standing poses of our n joints."""
    found = {
        name: np.tile(quaternion.IDENTITY, (len(segment.joints), 1))
        for name, segment in ours.segments.items()
        if name in theirs.segments
    }
    for side in SIDES:
        for limb in ("thigh", "shin"), ("upper_arm", "forearm"):
            above = quaternion.IDENTITY
            for name in (f"{side}_{part}" for part in limb):
                above = carry(above, ours.bone(name), theirs.bone(name))
                found[name][:] = above
        _turn_foot(found, theirs, ours, side)
        _turn_hand(found, theirs, ours, side)
    return found


def carry(above: Floats, ours: Floats, theirs: Floats) -> Floats:
    """Returns the rotation [4] that lays our bone [3] on theirs [3] and is nearest to `above`, that of another bone."""
    return quaternion.multiply(quaternion.between(quaternion.rotate(above, ours), theirs), above)


def _turn_foot(found: dict[str, Floats], theirs: Standing, ours: Standing, side: Side) -> None:
    """Turns foot and toes about the vertical only, for both feet are flat."""
    name = f"{side}_foot"
    their, our = (heading(rig.ahead(rig.segments[name].joints[0])) for rig in (theirs, ours))
    if their is None or our is None:
        return
    for part in (name, f"{side}_toe"):
        if part in found:
            found[part][:] = quaternion.about(UP, their - our)


def _turn_hand(found: dict[str, Floats], theirs: Standing, ours: Standing, side: Side) -> None:
    """Lays our palm on theirs if the fingers show both, and spreads the roll of the palm over the forearm."""
    forearm, hand = f"{side}_forearm", f"{side}_hand"
    found[hand][:] = found[forearm][-1]
    frames = []
    for rig in (theirs, ours):
        palm = palm_of(rig.skeleton, rig.roles, side)
        if palm is None:
            return
        wrist = rig.segments[hand].joints[0]
        frames.append(quaternion.multiply(rig.pose[wrist], frame(*palm)))
    turn = quaternion.multiply(frames[0], quaternion.conjugate(frames[1]))
    axis, ends = quaternion.unit(theirs.bone(forearm)), [*ours.segments[forearm].places, 1.0]
    roll = _roll(quaternion.multiply(turn, quaternion.conjugate(found[forearm][-1])), axis)
    middles = 0.5 * (np.array(ends[:-1]) + np.array(ends[1:]))
    found[forearm][:] = quaternion.multiply(quaternion.about(axis, roll * middles), found[forearm])
    found[hand][:] = turn


def _roll(turn: Floats, axis: Floats) -> float:
    """Returns the angle in radians, in [-pi, pi], by which a rotation [4] turns about a unit vector [3]."""
    angle = 2.0 * np.arctan2(turn[:3] @ axis, turn[3])
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
