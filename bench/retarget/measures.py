"""Measures of how much a retargeted motion keeps of the original."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.segments import segments_of
from motionsplice.motion.roles import SIDES, Roles
from motionsplice.precompute.body.contacts import foot_contacts

LIMBS = (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))


@dataclass(frozen=True, eq=False)
class Posed:
    """A clip, the roles of its joints, and their world positions [F, J, 3] and rotations [F, J, 4]."""

    clip: Clip
    roles: Roles
    positions: Floats
    rotations: Floats

    @classmethod
    def of(cls, clip: Clip, roles: Roles) -> Posed:
        """Computes the world transforms."""
        return cls(clip, roles, *world_transforms(clip.skeleton, clip.root_positions, clip.rotations))

    def at(self, role: str) -> Floats:
        """Returns the positions [F, 3] of the joint with a role."""
        return self.positions[:, getattr(self.roles, role)]

    @property
    def leg(self) -> float:
        """The length of the legs, metres."""
        return self.roles.leg_length(self.clip.skeleton)

    @property
    def trunk(self) -> Floats:
        """The vector [F, 3] from the middle of the hips to the middle of the shoulders."""
        return 0.5 * (self.at("left_shoulder") + self.at("right_shoulder") - self.at("left_hip") - self.at("right_hip"))


def limbs(a: Posed, b: Posed) -> float:
    """Returns the largest angle between directions of the eight limb bones, degrees."""
    ends = [(f"{side}_{upper}", f"{side}_{lower}") for side in SIDES for upper, lower in LIMBS]
    return max(_angle(a.at(lower) - a.at(upper), b.at(lower) - b.at(upper)) for upper, lower in ends)


def trunk(a: Posed, b: Posed) -> float:
    """Returns the largest angle between the lines from hips to shoulders, degrees."""
    return _angle(a.trunk, b.trunk)


def shoulder_line(a: Posed, b: Posed) -> float:
    """Returns the largest angle between the lines from shoulder to shoulder, degrees."""
    return _angle(*(one.at("left_shoulder") - one.at("right_shoulder") for one in (a, b)))


def ankles(a: Posed, b: Posed) -> float:
    """Returns the largest distance of an ankle from where it is in the original, in percent of a leg."""
    apart = [np.linalg.norm(a.at(f"{side}_ankle") / a.leg - b.at(f"{side}_ankle") / b.leg, axis=1) for side in SIDES]
    return 100.0 * float(np.max(apart))


def slide(a: Posed) -> float:
    """Returns the mean path of an ankle per second while its foot stands, in percent of a leg."""
    stands = foot_contacts(a.clip, a.roles)
    total, count = 0.0, 0
    for bit, side in enumerate(SIDES):
        held = (stands[1:] & stands[:-1] & (1 << bit)) > 0
        steps = np.linalg.norm(np.diff(a.at(f"{side}_ankle")[:, [0, 2]], axis=0), axis=1)
        total, count = total + float(steps[held].sum()), count + int(held.sum())
    return 100.0 * total * a.clip.rate / max(count, 1) / a.leg


def turn_errors(got: Posed, truth: Posed, parts: tuple[str, ...]) -> float:
    """Returns the largest angle of the first joints of segments to their rotations in the truth, degrees."""
    segments = segments_of(truth.clip.skeleton, truth.roles)
    joints = [segment.joints[0] for name, segment in segments.items() if name.endswith(parts)]
    return float(np.degrees(quaternion.angle(got.rotations[:, joints], truth.rotations[:, joints]).max()))


def _angle(u: Floats, v: Floats) -> float:
    """Returns the largest angle between vectors [F, 3], degrees."""
    turn = quaternion.between(u, v)
    return float(np.degrees(quaternion.angle(turn, quaternion.IDENTITY).max()))
