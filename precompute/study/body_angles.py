"""Bend, twist and lean of the upper body's joints, and the swing of the thighs (Heck's thesis, 4.1, steps 1, 2, 5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import hips_heading, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.posture import UP
from motionsplice.precompute.study.periodic import drift

SPINE_SPAN, NECK_SPAN = "shoulders over hips", "head over shoulders"


class View(StrEnum):
    """The reference of a joint's orientation: the direction of travel (global) or the joint above it (local)."""

    GLOBAL = "global"
    LOCAL = "local"


class Axis(StrEnum):
    """The body's axes. Positive bend tips the upright body forward, twist turns it left, lean tips it right."""

    BEND = "bend"  # about x, which points to the left
    TWIST = "twist"  # about y, up
    LEAN = "lean"  # about z, forward


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve of the study: a joint's angles [F] about one axis from its own mean orientation, radians."""

    view: View
    joint: str
    axis: Axis
    angles: Floats


def upper_body_curves(clip: Clip, roles: Roles, phase: Floats) -> tuple[Curve, ...]:
    """Returns the global and local curves of pelvis, spine, neck, head and arms; `phase` [F] is in strides.

    Joints are named by role, and their parent is the role above them, so that rigs can be compared. "shoulders over
    hips" is the rotation of the whole spine, "head over shoulders" of the whole neck. A curve is one component of the
    rotation vector from the joint's mean orientation, in axes that face the direction of travel. So the rig's local
    axes do not affect it.
    """
    world = _as_travelling(clip, roles, phase)
    joints = list(_joints(roles))
    vectors = [
        (View.GLOBAL, name, _from_mean(world[:, joint]))
        for joint, _, name in joints
        if name not in (SPINE_SPAN, NECK_SPAN)  # globally: the last spine joint, and the head
    ]
    vectors += [(View.LOCAL, name, _from_above(world, joint, above)) for joint, above, name in joints]
    return tuple(
        Curve(view, name, axis, angles)
        for view, name, turns in vectors
        for axis, angles in zip(Axis, turns.T, strict=True)
    )


def thigh_swing(clip: Clip, roles: Roles, phase: Floats) -> Floats:
    """Returns the swing [2, F] of left and right thigh: forward angle from the mean, relative to the root, radians."""
    world = _as_travelling(clip, roles, phase)
    hips = (roles.left_hip, roles.right_hip)
    return np.stack([-_from_above(world, hip, roles.root)[:, 0] for hip in hips])


def _joints(roles: Roles) -> Iterator[tuple[int, int, str]]:
    """Yields each joint, the joint that its local view is relative to, and its name."""
    above = roles.root
    for number, joint in enumerate((roles.pelvis, *roles.spine)):
        yield joint, above, f"spine {number}" if number else "pelvis"
        above = joint
    chest = above
    if roles.spine:
        yield chest, roles.root, SPINE_SPAN
    for name, joint in (("neck", roles.neck), ("head", roles.head)):
        if joint >= 0:
            yield joint, above, name
            above = joint
    if roles.neck >= 0 and roles.head >= 0:
        yield roles.head, chest, NECK_SPAN
    for side in ("left", "right"):
        above = chest
        for role in ("shoulder", "elbow", "wrist"):
            joint = getattr(roles, f"{side}_{role}")
            yield joint, above, f"{side} {role}"
            above = joint


def _as_travelling(clip: Clip, roles: Roles, phase: Floats) -> Floats:
    """Returns the orientations [F, J, 4] of all joints relative to the direction of travel.

    The direction of travel is the heading of the hips without their sway in each stride, which belongs to the body.
    """
    positions, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    heading = drift(np.unwrap(hips_heading(positions, roles)), phase)
    return quaternion.multiply(quaternion.about(UP, -heading)[:, None], world)


def _from_mean(orientations: Floats) -> Floats:
    """Returns the rotation vectors [F, 3], radians, from the mean of orientations [F, 4] to each of them."""
    turns = Rotation.from_quat(orientations)
    return np.asarray((turns * turns.mean().inv()).as_rotvec())


def _from_above(world: Floats, joint: int, above: int) -> Floats:
    """Returns the rotation vectors [F, 3], radians, of a joint relative to the joint `above`, from their mean.

    Their axes are the body's, with the joint `above` in its mean orientation.
    """
    local = quaternion.multiply(quaternion.conjugate(world[:, above]), world[:, joint])
    return np.asarray(Rotation.from_quat(world[:, above]).mean().apply(_from_mean(local)))
