"""The segments of a body: runs of joints that mean the same on every rig, however many joints a rig has there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import ARM, LEG, SIDES, Roles, common_ancestor, on_side
from motionsplice.motion.skeleton import Skeleton

LIMBS = ("thigh", "shin", "upper_arm", "forearm")  # segments whose direction matters, left and right


@dataclass(frozen=True, eq=False)
class Segment:
    """A run of joints of one rig, such as a forearm with its twist bones.

    joints: from the body outwards, at least one. end: the joint at which the segment ends; -1 if it is open, as a hand.
    bone: [3] metres, from its first joint to its end in the bind pose; zero if it is open.
    places: [n] where the joints lie along it, as a part of its length: the first at 0, and the end at 1. In an open
    segment, the last joint is at 1.
    """

    joints: tuple[int, ...]
    end: int
    bone: Floats
    places: Floats


def segments_of(skeleton: Skeleton, roles: Roles) -> dict[str, Segment]:
    """Returns the segments that a rig has, by name: limbs, trunk, neck, head, collars, hands and feet."""
    chest = common_ancestor(skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    found = {"root": _segment(skeleton, [roles.root]), "trunk": _segment(skeleton, _run(skeleton, roles.pelvis, chest))}
    for side in SIDES:
        hip, knee, ankle, toe = on_side(roles, side, (*LEG, "toe"))
        shoulder, elbow, wrist = on_side(roles, side, ARM)
        if collar := _run(skeleton, chest, shoulder)[1:-1]:
            found[f"{side}_collar"] = _segment(skeleton, collar, shoulder)
        for name, upper, lower in (
            ("thigh", hip, knee),
            ("shin", knee, ankle),
            ("upper_arm", shoulder, elbow),
            ("forearm", elbow, wrist),
        ):
            found[f"{side}_{name}"] = _segment(skeleton, _run(skeleton, upper, lower)[:-1], lower)
        found[f"{side}_hand"] = _segment(skeleton, [wrist])
        found[f"{side}_foot"] = _segment(skeleton, [ankle])
        if toe >= 0:
            found[f"{side}_toe"] = _segment(skeleton, [toe])
    if roles.neck >= 0:
        above = roles.head >= 0 and roles.neck in skeleton.chain(roles.head)[1:]
        neck = _run(skeleton, roles.neck, roles.head)[:-1] if above else [roles.neck]
        found["neck"] = _segment(skeleton, neck, roles.head if above else -1)
    if roles.head >= 0:
        found["head"] = _segment(skeleton, [roles.head])
    return found


def _run(skeleton: Skeleton, upper: int, lower: int) -> list[int]:
    """Returns the joints from `upper` down to `lower`, both included."""
    path = skeleton.chain(lower)
    return path[: path.index(upper) + 1][::-1]


def _segment(skeleton: Skeleton, joints: list[int], end: int = -1) -> Segment:
    stations = [*joints, end] if end >= 0 else joints
    lengths = [0.0, *(skeleton.bone_length(joint) for joint in stations[1:])]
    along = np.cumsum(lengths)
    places = along / along[-1] if along[-1] > 0.0 else np.linspace(0.0, 1.0, len(along))
    if len(stations) == 1:
        places = np.ones(1)
    bone = skeleton.offsets[stations[1:]].sum(axis=0) if end >= 0 else np.zeros(3)
    return Segment(tuple(joints), end, bone, places[: len(joints)])
