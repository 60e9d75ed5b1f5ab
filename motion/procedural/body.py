"""The built-in humanoid: 22 joints in a T-pose, and a solver for limbs of two bones.

Segment lengths are the fractions of stature of Drillis and Contini (1966), as printed by Winter,
Biomechanics and Motor Control of Human Movement, figure 4.1, for a stature of 1.78 m.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton

STATURE = 1.78  # metres
THIGH, SHANK, ANKLE_HEIGHT = 0.245 * STATURE, 0.246 * STATURE, 0.039 * STATURE
UPPER_ARM, FOREARM, HAND = 0.186 * STATURE, 0.146 * STATURE, 0.108 * STATURE
HEEL = (-0.055, -ANKLE_HEIGHT)  # from the ankle, forward and up, metres
BALL = (0.135, 0.024 - ANKLE_HEIGHT)  # the joint of the toes, likewise

UP: Floats = np.array([0.0, 1.0, 0.0])
LEFT, RIGHT = 1.0, -1.0  # the sign of a side's X

_SPINE = (
    ("Hips", "", (0.0, 0.0, 0.0)),
    ("Spine", "Hips", (0.0, 0.09, -0.01)),
    ("Spine1", "Spine", (0.0, 0.13, -0.01)),
    ("Spine2", "Spine1", (0.0, 0.13, 0.0)),
    ("Neck", "Spine2", (0.0, 0.19, 0.0)),
    ("Head", "Neck", (0.0, 0.09, 0.02)),
)
_ARM = (
    ("Shoulder", "Spine2", (0.04, 0.135, 0.0)),
    ("Arm", "Shoulder", (0.145, 0.0, 0.0)),
    ("ForeArm", "Arm", (UPPER_ARM, 0.0, 0.0)),
    ("Hand", "ForeArm", (FOREARM, 0.0, 0.0)),
)
_LEG = (
    ("UpLeg", "Hips", (0.09, -0.03, 0.0)),
    ("Leg", "UpLeg", (0.0, -THIGH, 0.0)),
    ("Foot", "Leg", (0.0, -SHANK, 0.0)),
    ("ToeBase", "Foot", (0.0, BALL[1], BALL[0])),
)
_ENDS = (
    ("Head", (0.0, 0.17, 0.0)),
    ("LeftHand", (HAND, 0.0, 0.0)),
    ("RightHand", (-HAND, 0.0, 0.0)),
    ("LeftToeBase", (0.0, -0.012, 0.07)),
    ("RightToeBase", (0.0, -0.012, 0.07)),
)


def _skeleton() -> Skeleton:
    joints = list(_SPINE)  # depth first, as in files, so that writing and reading a file keeps the order
    for limb in (_ARM, _LEG):
        for side, sign in (("Left", LEFT), ("Right", RIGHT)):
            for name, parent, (x, y, z) in limb:
                inner = parent in ("Spine2", "Hips")
                joints.append((side + name, parent if inner else side + parent, (sign * x, y, z)))
    names = tuple(name for name, _, _ in joints)
    return Skeleton(
        names=names,
        parents=np.array([names.index(parent) if parent else -1 for _, parent, _ in joints]),
        offsets=np.array([offset for _, _, offset in joints]),
        end_parents=np.array([names.index(name) for name, _ in _ENDS]),
        end_offsets=np.array([offset for _, offset in _ENDS]),
    )


SKELETON = _skeleton()


def side_name(side: float) -> str:
    return "Left" if side == LEFT else "Right"


def euler(yaw: ArrayLike, pitch: ArrayLike, roll: ArrayLike) -> Floats:
    """Returns the rotation by `roll` about Z, `pitch` about X (lean forward), then `yaw` about Y. [...] -> [..., 4]."""
    yaw, pitch, roll = np.broadcast_arrays(yaw, pitch, roll)
    turned = quaternion.multiply(quaternion.about([0.0, 1.0, 0.0], yaw), quaternion.about([1.0, 0.0, 0.0], pitch))
    return quaternion.multiply(turned, quaternion.about([0.0, 0.0, 1.0], roll))


class Limb(NamedTuple):
    """A solved limb: the directions of both bones and the axis of the hinge, each [F, 3] of unit length."""

    upper: Floats
    lower: Floats
    hinge: Floats


def two_bones(reach: Floats, pole: Floats, upper: float, lower: float) -> Limb:
    """Solves a limb of two bones, `upper` and `lower` metres long, whose end is `reach` [F, 3] from its first joint.

    The middle joint bends towards `pole` [F, 3]. A reach longer than the limb is shortened to its length.
    """
    distance = np.linalg.norm(reach, axis=-1, keepdims=True)
    along = reach / distance
    distance = np.minimum(distance, 0.9999 * (upper + lower))
    aside = pole - along * np.sum(pole * along, axis=-1, keepdims=True)
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    cosine = (upper**2 + distance**2 - lower**2) / (2.0 * upper * distance)
    sine = np.sqrt(1.0 - cosine**2)
    first = along * cosine + aside * sine
    second = (along * distance - first * upper) / lower
    return Limb(first, second, np.cross(aside, along))


def frame(x: Floats, y: Floats) -> Floats:
    """Returns the rotation [F, 4] that takes X to `x` and Y to `y`, perpendicular unit vectors [F, 3]."""
    return Rotation.from_matrix(np.stack([x, y, np.cross(x, y)], axis=-1)).as_quat()
