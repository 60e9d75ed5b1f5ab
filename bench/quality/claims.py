"""What the thesis says of its examples (Heck's thesis, 4.4), as numbers."""

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
    """A motion and the phase [F], in cycles, of its legs."""

    clip: Clip
    phase: Floats
    roles: Roles


@dataclass(frozen=True)
class Claim:
    """A number that a splice should have in common with the truth; `measure` also sees the action's own clip."""

    says: str
    unit: str
    measure: Callable[[Performance, Performance], float]


def _lean(shown: Performance, action: Performance) -> float:
    """Degrees that the shoulders are ahead of the pelvis, mean over the clip."""
    positions, roles = joint_positions(shown.clip), shown.roles
    shoulders = 0.5 * (positions[:, roles.left_shoulder] + positions[:, roles.right_shoulder])
    trunk = shoulders - positions[:, roles.pelvis]
    return float(np.degrees(np.arctan2(np.sum(trunk * forward(positions, roles), axis=1), trunk[:, 1])).mean())


def _tilt(shown: Performance, action: Performance) -> float:
    """Degrees by which the right hand tilts from how the action holds it, 95th percentile."""
    up = [_up_in_hand(one) for one in (shown, action)]
    held = up[1].mean(axis=0)
    return float(np.degrees(np.percentile(np.arccos(np.clip(up[0] @ (held / np.linalg.norm(held)), -1.0, 1.0)), 95)))


def _timing(shown: Performance, action: Performance) -> float:
    """Degrees of a stride by which the punches are off where the action has them against its own legs."""
    means = [resultant(one.phase[_punches(one)]) for one in (shown, action)]
    return float(np.degrees(np.abs(np.angle(means[0] * np.conj(means[1])))))


def _steadiness(shown: Performance, action: Performance) -> float:
    """How much alike the phases of the punches are, 1 if all agree."""
    return concentration(shown.phase[_punches(shown)])


def _twist(shown: Performance, action: Performance) -> float:
    """Degrees of amplitude with which the shoulders turn against the hips."""
    turned = _shoulders_against_hips(shown)
    return float(np.degrees(np.sqrt(2.0) * np.std(turned)))


def _growth(shown: Performance, action: Performance) -> float:
    """The twist's amplitude in the last third of the clip, as a ratio to the first."""
    turned = _shoulders_against_hips(shown)
    third = len(turned) // 3
    return float(np.std(turned[-third:]) / np.std(turned[:third]))


CLAIMS: Mapping[str, Claim] = MappingProxyType(
    {
        "lean": Claim("trunk's forward lean", "°", _lean),
        "tilt": Claim("the cup's tilt, 95th percentile", "°", _tilt),
        "timing": Claim("punches off the action's timing against the legs", "° of a stride", _timing),
        "steadiness": Claim("punches at one phase of the stride (1: all)", "", _steadiness),
        "twist": Claim("shoulders' twist against the hips", "°", _twist),
        "growth": Claim("twist, last third over first third", "times", _growth),
    }
)


def _up_in_hand(shown: Performance) -> Floats:
    """The vertical [F, 3] as seen from the right hand."""
    world = world_transforms(shown.clip.skeleton, shown.clip.root_positions, shown.clip.rotations)[1]
    return quaternion.rotate(quaternion.conjugate(world[:, shown.roles.right_wrist]), np.array([0.0, 1.0, 0.0]))


def _punches(shown: Performance) -> Floats:
    """The frames at which the right hand is farthest from its shoulder, once a stride at most."""
    positions = joint_positions(shown.clip)
    reach = np.linalg.norm(positions[:, shown.roles.right_wrist] - positions[:, shown.roles.right_shoulder], axis=1)
    stride = len(reach) / (shown.phase[-1] - shown.phase[0])
    return np.asarray(find_peaks(reach, distance=max(1.0, 0.6 * stride), prominence=0.25 * np.ptp(reach))[0])


def _shoulders_against_hips(shown: Performance) -> Floats:
    """The turn [F] of the shoulders against the hips about the vertical, radians."""
    positions, roles = joint_positions(shown.clip), shown.roles
    hips = positions[:, roles.left_hip] - positions[:, roles.right_hip]
    shoulders = positions[:, roles.left_shoulder] - positions[:, roles.right_shoulder]
    across = hips[:, 2] * shoulders[:, 0] - hips[:, 0] * shoulders[:, 2]
    return np.arctan2(across, hips[:, 0] * shoulders[:, 0] + hips[:, 2] * shoulders[:, 2])
