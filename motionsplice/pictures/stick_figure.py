"""Stick figures: the bones of a rig that are drawn, their thickness and colour, and how they are painted."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import end_positions, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.pictures.brush import WHITE, Brush, Colour, mixed

# Blue and vermilion of Okabe and Ito's palette, which colour-blind people can distinguish.
LEFT: Colour = (0, 114, 178)
RIGHT: Colour = (213, 94, 0)
TRUNK: Colour = (72, 79, 88)
TORSO: Colour = (226, 229, 233)
GHOST: Colour = (190, 195, 202)

# Radii relative to the length of a leg.
HEAD, SPINE, GIRDLE = 0.118, 0.032, 0.02
ARM, HAND, FINGER = (0.04, 0.034, 0.026), 0.018, 0.008
LEG, FOOT = (0.046, 0.038, 0.028), 0.019
DOT, NOSE, CASING = 0.013, 0.022, 0.022


class Bone(NamedTuple):
    """A bone between two points, tapering between its radii there, relative to the length of a leg."""

    start: int
    stop: int
    start_radius: float
    stop_radius: float


class Limb(NamedTuple):
    """A group of bones that is painted together, and the points that get a joint dot."""

    colour: Colour
    bones: tuple[Bone, ...]
    dots: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class StickFigure:
    """How one rig is drawn. Points are its J joints, E end sites, the head's centre and the nose, in that order.

    limbs:      shoulder and hip girdle, the spine up to the head, then arms and legs.
    torso:      shoulders and hips, the corners of a filled polygon that makes lean and twist visible.
    head:       the joint that carries the head.
    head_shape: [2, 3] metres, the head's centre and the nose in the frame of that joint.
    unit:       length of a leg in metres, to which all thicknesses are relative.
    """

    skeleton: Skeleton
    limbs: tuple[Limb, ...]
    torso: tuple[int, ...]
    head: int
    head_shape: Floats
    unit: float

    @classmethod
    def of(cls, skeleton: Skeleton, roles: Roles) -> StickFigure:
        """Returns the figure of a rig, without bones that do not lead to head, hands or feet (twist, target, face)."""
        shoulders, hips = (roles.left_shoulder, roles.right_shoulder), (roles.right_hip, roles.left_hip)
        other_arm = skeleton.chain(roles.right_shoulder)
        fork = next(joint for joint in skeleton.chain(roles.left_shoulder) if joint in other_arm)
        head = next(joint for joint in (roles.head, roles.neck, fork) if joint >= 0)
        pairs = [(fork, shoulder) for shoulder in shoulders] + [(roles.root, hip) for hip in hips]
        girdles = [bone for pair in pairs for bone in _chain(skeleton, pair, (GIRDLE, GIRDLE))]
        spine = _chain(skeleton, (roles.root, head), (SPINE, SPINE))
        spine.append(Bone(head, skeleton.joint_count + len(skeleton.end_parents), SPINE, SPINE))
        left_arm = (roles.left_shoulder, roles.left_elbow, roles.left_wrist)
        right_arm = (roles.right_shoulder, roles.right_elbow, roles.right_wrist)
        left_leg = (roles.left_hip, roles.left_knee, roles.left_ankle)
        right_leg = (roles.right_hip, roles.right_knee, roles.right_ankle)
        limbs = [Limb(TRUNK, tuple(girdles), ()), Limb(TRUNK, tuple(spine), (roles.pelvis,))]
        for colour, arm in ((LEFT, left_arm), (RIGHT, right_arm)):
            hand = _tips(skeleton, arm[-1], HAND)
            tips = len({bone.stop for bone in hand} - {bone.start for bone in hand})
            hand = hand if tips <= 2 else _tips(skeleton, arm[-1], FINGER)
            limbs.append(Limb(colour, (*_chain(skeleton, arm, ARM), *hand), arm))
        for colour, leg in ((LEFT, left_leg), (RIGHT, right_leg)):
            limbs.append(Limb(colour, (*_chain(skeleton, leg, LEG), *_tips(skeleton, leg[-1], FOOT)), leg))
        unit = roles.leg_length(skeleton)
        head_shape = _head_shape(skeleton, roles, head) * (HEAD * unit)
        return cls(skeleton, tuple(limbs), (*shoulders, *hips), head, head_shape, unit)

    def points(self, root_positions: Floats, rotations: Floats) -> Floats:
        """Returns the world positions [n, J + E + 2, 3] of all points, in metres, of poses [n, 3] and [n, J, 4]."""
        positions, world = world_transforms(self.skeleton, root_positions, rotations)
        ends = end_positions(self.skeleton, positions, world)
        head = positions[:, [self.head]] + quaternion.rotate(world[:, [self.head]], self.head_shape)
        return np.concatenate([positions, ends, head], axis=1)

    def middles(self, points: Floats, ground: float) -> Floats:
        """Returns the point at the middle of the view [n, 3]: on the floor, at height `ground`, under the root."""
        return np.asarray(points[:, 0] * [1.0, 0.0, 1.0] + [0.0, ground, 0.0])

    def bounds(self, points: Floats) -> Floats:
        """Returns the least and greatest coordinates [2, k] that the figure with points [n, P, k] covers, in metres."""
        drawn = sorted({point for limb in self.limbs for bone in limb.bones for point in bone[:2]})
        radii = np.full((len(drawn), 1), max(LEG) * self.unit)
        radii[drawn.index(points.shape[1] - 2)] = HEAD * self.unit
        reach = points[:, drawn]
        return np.stack([(reach - radii).min(axis=(0, 1)), (reach + radii).max(axis=(0, 1))])

    def paint(self, brush: Brush, points: Floats, *, fade: float = 0.0) -> None:
        """Paints a pose from back to front. Arms and legs have a white casing against their background.

        points [P, 3] metres to the right, up and towards the viewer; `fade` (0 to 1) mixes in white.
        """
        flat, depths = points[:, :2], points[:, 2]
        girdles, spine, *_ = self.limbs
        brush.polygon(flat[list(self.torso)], mixed(TORSO, fade))
        self._paint_bones(brush, flat, girdles, mixed(TRUNK, fade))
        for limb in sorted(self.limbs[1:], key=lambda limb: np.mean(depths[[bone.stop for bone in limb.bones]])):
            colour = mixed(limb.colour, fade)
            if limb is not spine:
                self._paint_casing(brush, flat, limb)
            self._paint_bones(brush, flat, limb, colour)
            if limb is spine:
                self._paint_head(brush, points, colour)
            for point in limb.dots:
                brush.disc(flat[point], DOT * self.unit, WHITE)

    def paint_ghost(self, brush: Brush, points: Floats) -> None:
        """Paints a pose [P, 2 or 3] entirely in pale grey."""
        flat = points[:, :2]
        for limb in self.limbs:
            self._paint_bones(brush, flat, limb, GHOST)
        brush.disc(flat[-2], HEAD * self.unit, GHOST)

    def _paint_head(self, brush: Brush, points: Floats, colour: Colour) -> None:
        """Paints a disc with a paler nose, which is in front of the disc if the face is turned to the viewer."""
        centre, nose = points[-2], points[-1]
        faces_viewer = bool(nose[2] > centre[2])
        if faces_viewer:
            brush.disc(centre[:2], HEAD * self.unit, colour)
        bridge = centre + 0.55 * (nose - centre)
        brush.taper(bridge[:2], nose[:2], 1.4 * NOSE * self.unit, NOSE * self.unit, mixed(colour, 0.45))
        if not faces_viewer:
            brush.disc(centre[:2], HEAD * self.unit, colour)

    def _paint_bones(self, brush: Brush, points: Floats, limb: Limb, colour: Colour) -> None:
        for start, stop, start_radius, stop_radius in limb.bones:
            brush.taper(points[start], points[stop], start_radius * self.unit, stop_radius * self.unit, colour)

    def _paint_casing(self, brush: Brush, points: Floats, limb: Limb) -> None:
        """Paints a white casing around an arm or a leg, except where it joins the trunk."""
        joined = limb.bones[0].start
        for start, stop, start_radius, stop_radius in limb.bones:
            first = points[start] + (0.35 * (points[stop] - points[start]) if start == joined else 0.0)
            radii = (start_radius + CASING) * self.unit, (stop_radius + CASING) * self.unit
            brush.taper(first, points[stop], *radii, WHITE)


def _chain(skeleton: Skeleton, joints: tuple[int, ...], radii: tuple[float, ...]) -> list[Bone]:
    """The bones from the first of `joints` down to the last, tapering between the radii given at these."""
    bones = []
    for (upper, lower), (first, last) in zip(pairwise(joints), pairwise(radii), strict=True):
        upwards = skeleton.chain(lower)
        chain = upwards[upwards.index(upper) :: -1]
        steps = np.linspace(first, last, len(chain)).tolist()
        bones += [Bone(*ends, *taper) for ends, taper in zip(pairwise(chain), pairwise(steps), strict=True)]
    return bones


def _tips(skeleton: Skeleton, joint: int, radius: float) -> list[Bone]:
    """Returns the bones below a wrist or an ankle, with end sites, all of one radius."""
    below = skeleton.subtree(joint)
    bones = [Bone(int(skeleton.parents[child]), child, radius, radius) for child in below[1:]]
    ends = enumerate(skeleton.end_parents.tolist(), skeleton.joint_count)
    return bones + [Bone(parent, end, radius, radius) for end, parent in ends if parent in below]


def _head_shape(skeleton: Skeleton, roles: Roles, head: int) -> Floats:
    """Returns the head's centre and the nose [2, 3] in the frame of the joint `head`, relative to the head's radius.

    The bone below the head gives the direction up, the hips in the bind pose the direction to the front. This works for
    any orientation of the bind pose, in which local frames are aligned with the world.
    """
    up = _direction(skeleton.offsets[head], np.array([0.0, 1.0, 0.0]))
    bind = np.tile(quaternion.IDENTITY, (1, skeleton.joint_count, 1))
    positions = world_transforms(skeleton, np.zeros((1, 3)), bind)[0][0]
    front = _direction(np.cross(positions[roles.left_hip] - positions[roles.right_hip], up), np.array([0.0, 0.0, 1.0]))
    return np.stack([0.7 * up, 0.55 * up + 1.3 * front])


def _direction(vector: Floats, otherwise: Floats) -> Floats:
    length = np.linalg.norm(vector)
    return np.asarray(vector / length) if length > 1e-6 else otherwise
