"""Which joint of a rig is the root, the pelvis, a knee, a shoulder ..."""

from __future__ import annotations

from dataclasses import dataclass

from motion.skeleton import Skeleton


@dataclass(frozen=True)
class Roles:
    """Joint indices by role. See DESIGN's words: the pelvis is where the upper body hangs on the root.

    `spine` runs from the pelvis's child up to the joint at which the two arms part, so it may be empty.
    `neck`, `head` and the toes are -1 on rigs that have none.
    """

    root: int
    pelvis: int
    spine: tuple[int, ...]
    neck: int
    head: int
    left_hip: int
    left_knee: int
    left_ankle: int
    left_toe: int
    right_hip: int
    right_knee: int
    right_ankle: int
    right_toe: int
    left_shoulder: int
    left_elbow: int
    left_wrist: int
    right_shoulder: int
    right_elbow: int
    right_wrist: int

    @property
    def lower_cloud(self) -> tuple[int, ...]:
        """The joints that time alignment looks at (Heck et al. 2006, 3.1)."""
        return (self.root, self.left_knee, self.right_knee)

    @property
    def upper_cloud(self) -> tuple[int, ...]:
        """The joints that spatial alignment looks at, the pelvis itself apart (Heck et al. 2006, 3.2)."""
        return (*self.spine, self.left_shoulder, self.right_shoulder)

    def leg_length(self, skeleton: Skeleton) -> float:
        """Metres from hip over knee to ankle, mean of both legs."""
        bones = (self.left_knee, self.left_ankle, self.right_knee, self.right_ankle)
        return sum(skeleton.bone_length(joint) for joint in bones) / 2.0
