"""Numbers that check what Heck's thesis says about its examples (4.4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.signal import find_peaks

from bench.quality.rhythm import concentration, forward, resultant
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles


@dataclass(frozen=True, eq=False)
class Performance:
    """A clip, the phase [F] of its legs in cycles, and its roles."""

    clip: Clip
    phase: Floats
    roles: Roles


@dataclass(frozen=True)
class Claim:
    """A number that should be the same for a splice and its truth.

    `measure` takes the motion to measure, and the action's own clip for comparison.
    """

    label: str
    unit: str
    measure: Callable[[Performance, Performance], float]


def _lean(motion: Performance, action: Performance) -> float:
    """Returns the mean forward lean of the trunk, from pelvis to shoulders, in degrees."""
    positions, roles = joint_positions(motion.clip), motion.roles
    shoulders = 0.5 * (positions[:, roles.left_shoulder] + positions[:, roles.right_shoulder])
    trunk = shoulders - positions[:, roles.pelvis]
    return float(np.degrees(np.arctan2(np.sum(trunk * forward(positions, roles), axis=1), trunk[:, 1])).mean())


def _tilt(motion: Performance, action: Performance) -> float:
    """Returns the 95th percentile of the right hand's tilt from its mean in the action's clip, in degrees."""
    up = [_up_in_hand(one) for one in (motion, action)]
    held = up[1].mean(axis=0)
    return float(np.degrees(np.percentile(np.arccos(np.clip(up[0] @ (held / np.linalg.norm(held)), -1.0, 1.0)), 95)))


def _timing(motion: Performance, action: Performance) -> float:
    """Returns how far the mean phase of the punches is from that in the action's clip, in degrees of a stride."""
    means = [resultant(one.phase[_punches(one)]) for one in (motion, action)]
    return float(np.degrees(np.abs(np.angle(means[0] * np.conj(means[1])))))


def _steadiness(motion: Performance, action: Performance) -> float:
    """Returns the concentration of the punches' phases: 1 if all are equal, 0 if they are spread evenly."""
    return concentration(motion.phase[_punches(motion)])


def _twist(motion: Performance, action: Performance) -> float:
    """Returns the amplitude of the shoulders' turn relative to the hips, in degrees."""
    turned = _shoulders_against_hips(motion)
    return float(np.degrees(np.sqrt(2.0) * np.std(turned)))


def _growth(motion: Performance, action: Performance) -> float:
    """Returns the twist's amplitude in the last third of the clip, divided by that in the first third."""
    turned = _shoulders_against_hips(motion)
    third = len(turned) // 3
    return float(np.std(turned[-third:]) / np.std(turned[:third]))


CLAIMS: Mapping[str, Claim] = MappingProxyType(
    {
        "lean": Claim("forward lean of the trunk", "°", _lean),
        "tilt": Claim("tilt of the cup, 95th percentile", "°", _tilt),
        "timing": Claim("phase of the punches, difference from the action's", "° of a stride", _timing),
        "steadiness": Claim("concentration of the punches' phases (1: all equal)", "", _steadiness),
        "twist": Claim("twist of the shoulders against the hips", "°", _twist),
        "growth": Claim("twist in the last third / in the first third", "times", _growth),
    }
)


def _up_in_hand(motion: Performance) -> Floats:
    """Returns the vertical [F, 3] in the right hand's frame."""
    world = world_transforms(motion.clip.skeleton, motion.clip.root_positions, motion.clip.rotations)[1]
    return quaternion.rotate(quaternion.conjugate(world[:, motion.roles.right_wrist]), np.array([0.0, 1.0, 0.0]))


def _punches(motion: Performance) -> Floats:
    """Returns the frames at which the right hand is farthest from its shoulder, at most once per stride."""
    positions = joint_positions(motion.clip)
    reach = np.linalg.norm(positions[:, motion.roles.right_wrist] - positions[:, motion.roles.right_shoulder], axis=1)
    stride = len(reach) / (motion.phase[-1] - motion.phase[0])
    return np.asarray(find_peaks(reach, distance=max(1.0, 0.6 * stride), prominence=0.25 * np.ptp(reach))[0])


def _shoulders_against_hips(motion: Performance) -> Floats:
    """Returns the turn [F] of the shoulders relative to the hips about the vertical, in radians."""
    positions, roles = joint_positions(motion.clip), motion.roles
    hips = positions[:, roles.left_hip] - positions[:, roles.right_hip]
    shoulders = positions[:, roles.left_shoulder] - positions[:, roles.right_shoulder]
    across = hips[:, 2] * shoulders[:, 0] - hips[:, 0] * shoulders[:, 2]
    return np.arctan2(across, hips[:, 0] * shoulders[:, 0] + hips[:, 2] * shoulders[:, 2])
