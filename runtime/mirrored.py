"""The mirror images of a bank's clips: a clip's name with MIRRORED names its mirror image."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.mirror import FLIP, Mirror
from motionsplice.motion.parts import PART_NAMES, TWIN_PARTS
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.motion.twins import MIRROR
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT
from motionsplice.runtime.format.entries import ClipEntry
from motionsplice.runtime.format.rows import TorsoRows

MIRRORED = "~mirror"
HALF_A_CYCLE = 0.5  # a mirror image's left foot stands where the clip's right foot does


def mirrored_name(name: str) -> str:
    """Returns the name of a clip's mirror image, or of the clip for that of its mirror image."""
    return name.removesuffix(MIRRORED) if name.endswith(MIRRORED) else name + MIRRORED


def mirrored_entry(clip: ClipEntry) -> ClipEntry:
    """Returns the entry of a clip's mirror image. It has the clip's rows."""
    return replace(
        clip,
        name=mirrored_name(clip.name),
        first_phase=clip.first_phase + HALF_A_CYCLE,
        last_phase=clip.last_phase + HALF_A_CYCLE,
        parts=sum((clip.parts >> twin & 1) << part for part, twin in enumerate(TWIN_PARTS)),
        uses=tuple(name for name, twin in zip(PART_NAMES, TWIN_PARTS, strict=True) if PART_NAMES[twin] in clip.uses),
        stretches=tuple(map(mirrored_name, clip.stretches)),
    )


def mirrored_path(path: Floats) -> Floats:
    """Mirrors a root path [..., 4]: x, height of the ground, z, heading."""
    return np.asarray(path * [-1.0, 1.0, 1.0, -1.0])


def mirrored_posture(posture: Floats) -> Floats:
    """Mirrors a posture [2, 3]: the left and the right shoulder."""
    return np.asarray(posture[::-1] * MIRROR)


def mirrored_contacts(standing: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Exchanges the bits of both feet."""
    left, right = standing & LEFT_FOOT, standing & RIGHT_FOOT
    return np.asarray(left // LEFT_FOOT * RIGHT_FOOT + right // RIGHT_FOOT * LEFT_FOOT, np.uint8)


@np.errstate(invalid="ignore")  # the numbers of a bank that is not verified may be infinite
def mirrored_rotations(rotations: Floats, mirror: Mirror, skeleton: Skeleton) -> Floats:
    """Mirrors local rotations [..., J, 4]."""
    return mirror.rotations(rotations, skeleton.parents)


@np.errstate(invalid="ignore")  # as above
def mirrored_torso(torso: TorsoRows, mirror: Mirror, skeleton: Skeleton, roles: Roles) -> TorsoRows:
    """Mirrors the torso data of n frames."""
    above = mirror.turns[skeleton.parents[roles.pelvis]]
    return TorsoRows(
        clouds=mirrored_points(torso.clouds, mirror, roles),
        frames=quaternion.multiply(quaternion.conjugate(above), torso.frames * FLIP),
        offsets=torso.offsets * FLIP,
    )


def mirrored_points(clouds: Floats, mirror: Mirror, roles: Roles) -> Floats:
    """Mirrors upper clouds [n, points, 3] in the pelvis's frame, whose last two points are the shoulders."""
    order = [*range(clouds.shape[1] - 2), clouds.shape[1] - 1, clouds.shape[1] - 2]
    turn: Any = quaternion.conjugate(mirror.turns[roles.pelvis])
    return quaternion.rotate(turn, clouds[:, order] * MIRROR)
