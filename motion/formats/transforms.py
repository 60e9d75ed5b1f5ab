"""Transforms of the nodes of scene files, [..., 3, 4]: three columns of axes, with their scale, and a position."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers


def local_transforms(translations: Floats, rotations: Floats, scales: Floats) -> Floats:
    """Returns a node's transforms to its parent [3, 4, F], from their parts [F or 1, 3], [F or 1, 4], [F or 1, 3]."""
    local = np.empty((3, 4, max(map(len, (translations, rotations, scales)))))
    axes = quaternion.to_matrices(rotations).transpose(1, 2, 0)
    local[:, :3], local[:, 3] = axes * scales.T, translations.T
    return local


def in_the_world(locals_: Iterable[Floats], parents: Integers, frames: int) -> Floats:
    """Returns world transforms [F, N, 3, 4] of nodes with transforms to their parents [3, 4, F or 1].

    parents: [N], parent before child, negative for those at the top. In memory all frames of a number lie together,
    because the work goes from node to node.
    """
    world = np.empty((len(parents), 3, 4, frames))
    for node, local in enumerate(locals_):
        if parents[node] < 0:
            world[node] = local
        else:
            above = world[parents[node]]
            world[node] = above[:, 0, None] * local[0] + above[:, 1, None] * local[1] + above[:, 2, None] * local[2]
            world[node, :, 3] += above[:, 3]
    return world.transpose(3, 0, 1, 2)


def rotations_of(transforms: Floats) -> Floats:
    """Returns the rotations [..., 4] of transforms [..., 3, 4]: their axes without scale, made orthogonal."""
    axes = np.moveaxis(transforms, (-2, -1), (1, 0))[:3]
    x = _unit(axes[0])
    y = _unit(axes[1] - np.sum(x * axes[1], axis=0) * x)
    z = x[[1, 2, 0]] * y[[2, 0, 1]] - x[[2, 0, 1]] * y[[1, 2, 0]]
    return quaternion.from_matrices(np.moveaxis(np.stack([x, y, z], axis=1), (0, 1), (-2, -1)))


def _unit(v: Floats) -> Floats:
    """Returns vectors [3, ...] at length 1, or 0 if they have none."""
    length = np.sqrt(np.sum(v * v, axis=0))
    return v / np.where(length > 0.0, length, 1.0)
