"""Practical lower bounds for the error of a splice: an oracle that knows the truth, and the spread of strides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.quality.measures import over_root
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.best_rotations import best_rotations
from motionsplice.precompute.body.joint_paths import upper_joints
from motionsplice.precompute.body.posture import Torso, measure_torso
from motionsplice.precompute.splice import sampled_offsets

ORACLE_RATE = 30.0  # frames per second at which the oracle picks frames


@dataclass(frozen=True, eq=False)
class Laying:
    """Lays any frame of an action on any frame of a locomotion, as a splice does, and compares it with the truth.

    local: [Fu, n, 3] the action's joints in its pelvis's frame, metres. pelvis: [F, 4] local rotations of the
    locomotion's pelvis. above: [F, 4] world rotations of its parent. goals: [F, n, 3] the truth's joints over the
    locomotion's pelvis, metres. offsets: torso offsets of the locomotion [F, 4] and of the action [Fu, 4].
    """

    torso_l: Torso
    torso_u: Torso
    offsets: tuple[Floats, Floats]
    local: Floats
    pelvis: Floats
    above: Floats
    goals: Floats

    @classmethod
    def of(cls, locomotion: Clip, action: Clip, truth: Clip, offsets: tuple[Floats, Floats], roles: Roles) -> Laying:
        """Prepares the frames that locomotion and truth have in common."""
        used = locomotion.frames(0, min(locomotion.frame_count, truth.frame_count))
        positions, world = world_transforms(used.skeleton, used.root_positions, used.rotations)
        pelvis = positions[:, [roles.pelvis]] - positions[:, :1]
        return cls(
            torso_l=measure_torso(used, roles),
            torso_u=measure_torso(action, roles),
            offsets=offsets,
            local=upper_joints(action, roles),
            pelvis=used.rotations[:, roles.pelvis],
            above=world[:, int(used.skeleton.parents[roles.pelvis])],
            goals=over_root(truth.frames(0, used.frame_count), roles) - pelvis,
        )

    def errors(self, frames: NDArray[np.int64], action_frames: Floats) -> Floats:
        """Returns the mean error [n] in metres of real-valued action frames [n] on frames [n] of the locomotion."""
        local, clouds = (quaternion.interpolated(table, action_frames) for table in (self.local, self.torso_u.clouds))
        theirs = sampled_offsets(self.offsets[1], action_frames)
        turn = quaternion.multiply(theirs, quaternion.conjugate(self.offsets[0][frames]))
        frame = self.torso_l.frames[frames]
        lean = quaternion.multiply(quaternion.multiply(frame, turn), quaternion.conjugate(frame))
        aligned = best_rotations(self.torso_l.clouds[frames], clouds)
        pelvis = quaternion.multiply(lean, quaternion.multiply(self.pelvis[frames], aligned))
        turned = quaternion.rotate(quaternion.multiply(self.above[frames], pelvis)[:, None], local)
        return np.asarray(np.linalg.norm(turned - self.goals[frames], axis=-1).mean(axis=1))

    def grid(self, frames: NDArray[np.int64], action_frames: NDArray[np.int64]) -> Floats:
        """Returns the mean error [n, m] in metres of each of m action frames on each of n frames of the locomotion."""
        candidates = action_frames.astype(np.float64)
        return np.stack([self.errors(np.full(len(candidates), frame), candidates) for frame in frames])


def sampled_frames(count: int, rate: float) -> NDArray[np.int64]:
    """Returns the frame numbers of a clip of `count` frames at about ORACLE_RATE."""
    return np.arange(0, count, max(1, round(rate / ORACLE_RATE)))
