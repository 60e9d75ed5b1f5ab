"""How the joints of the upper body bend, twist and lean, and how the thighs swing (thesis 4.1, steps 1, 2 and 5)."""

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
    """What a joint's orientation is seen from: the direction of travel, or the joint that it hangs on."""

    GLOBAL = "global"
    LOCAL = "local"


class Axis(StrEnum):
    """The body's axes: bend tips what stands up forward, twist turns to the left, lean tips it to the right."""

    BEND = "bend"  # about x, which points to the left
    TWIST = "twist"  # about y, up
    LEAN = "lean"  # about z, forward


@dataclass(frozen=True, eq=False)
class Curve:
    """One data line of the study: angles [F] in radians about one axis, from the joint's own mean orientation."""

    view: View
    joint: str
    axis: Axis
    angles: Floats


def upper_body_curves(clip: Clip, roles: Roles, phase: Floats) -> tuple[Curve, ...]:
    """The global and local curves of pelvis, spine, neck, head and arms; phase [F] is the clip's, in strides.

    Joints go by role, and hang on the role above them, so that rigs can be compared; "shoulders over hips" is the
    whole spine's turn, "head over shoulders" the whole neck's. A curve is the rotation vector from the joint's mean
    orientation, in axes that face the way of travel, so the rig's local axes have no part in it.
    """
    world = _as_travelling(clip, roles, phase)
    joints = list(_joints(roles))
    vectors = [
        (View.GLOBAL, name, _from_mean(world[:, joint]))
        for joint, _, name in joints
        if name not in (SPINE_SPAN, NECK_SPAN)  # the last joint's own, seen along the way
    ]
    vectors += [(View.LOCAL, name, _from_above(world, joint, above)) for joint, above, name in joints]
    return tuple(
        Curve(view, name, axis, angles)
        for view, name, turns in vectors
        for axis, angles in zip(Axis, turns.T, strict=True)
    )


def thigh_swing(clip: Clip, roles: Roles, phase: Floats) -> Floats:
    """How far forward of their means the left and the right thigh are with respect to the root [2, F], radians."""
    world = _as_travelling(clip, roles, phase)
    hips = (roles.left_hip, roles.right_hip)
    return np.stack([-_from_above(world, hip, roles.root)[:, 0] for hip in hips])


def _joints(roles: Roles) -> Iterator[tuple[int, int, str]]:
    """Joint, the joint that it is seen from locally, and its name."""
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
    """Orientations [F, J, 4] of all joints as seen by one who travels along.

    Travel is where the hips face but for their own sway in each stride, which is the body's and not the way's.
    """
    positions, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    heading = drift(np.unwrap(hips_heading(positions, roles)), phase)
    return quaternion.multiply(quaternion.about(UP, -heading)[:, None], world)


def _from_mean(orientations: Floats) -> Floats:
    """Rotation vectors [F, 3] in radians from the mean of orientations [F, 4] to each."""
    turns = Rotation.from_quat(orientations)
    return np.asarray((turns * turns.mean().inv()).as_rotvec())


def _from_above(world: Floats, joint: int, above: int) -> Floats:
    """The same of a joint as seen from the joint `above`, along the body's axes in the mean orientation of that."""
    local = quaternion.multiply(quaternion.conjugate(world[:, above]), world[:, joint])
    return np.asarray(Rotation.from_quat(world[:, above]).mean().apply(_from_mean(local)))
