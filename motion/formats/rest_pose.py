"""Files that state no bind pose: the pose at rest stands in for it, unless that is a frame of the motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motionsplice.motion.formats.scene import Scene
from motionsplice.motion.quaternion import Floats, unit
from motionsplice.motion.roles import LIMBS, NOTHING_GIVEN, limbs_by_name

ALIKE = 1e-3  # of the body's size: poses whose joints are nearer are the same
SYMMETRIC = 0.02  # of the body's size: a pose made to bind a mesh to is symmetric, and a moment of a motion is not


def with_own_bind(scene: Scene) -> Scene:
    """Replaces a pose at rest that is a frame of the motion by the pose in which the axes of all joints are parallel.

    If an animation has no mesh, some exporters write the moment of the export as the pose at rest. It differs from file
    to file, so clips of one rig would have different bind poses. The axes of the joints are the same in all of them.
    """
    if scene.bound or len(scene.world) < 2:
        return scene
    found = limbs_by_name(scene.names, NOTHING_GIVEN)
    at = scene.bind[..., 3]
    apart = np.abs(scene.world[..., 3] - at).max(axis=(1, 2)).min()
    posed = not set(LIMBS) <= set(found) or _symmetric(at[[found[role] for role in LIMBS]])
    if posed or apart > ALIKE * np.ptp(at, axis=0).max():
        note = "it states no bind pose; the pose of its nodes at rest is taken"
        return replace(scene, notes=(*scene.notes, note))
    bind = np.zeros_like(scene.bind)
    bind[..., :3] = np.eye(3)
    for node, parent in enumerate(scene.parents.tolist()):
        bind[node, :, 3] = at[node]
        if parent >= 0:
            axes = unit(scene.bind[parent, :, :3].T)
            bind[node, :, 3] = bind[parent, :, 3] + axes @ (at[node] - at[parent])
    note = (
        "it states no bind pose, and rests in a frame of the motion; the pose in which all axes are parallel is taken"
    )
    return replace(scene, bind=bind, notes=(*scene.notes, note))


def _symmetric(limbs: Floats) -> bool:
    """Returns whether a pose looks the same with left and right exchanged; limbs [n, 3], left and right in turns."""
    sides = np.arange(len(limbs)) ^ 1
    apart = np.linalg.norm(limbs[:, None] - limbs, axis=-1)
    return bool(np.abs(apart - apart[np.ix_(sides, sides)]).max() < SYMMETRIC * apart.max())
