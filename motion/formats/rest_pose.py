"""Files that state no bind pose: the pose at rest stands in for it, unless that is a frame of the motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motionsplice.motion.formats.scene import Scene
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import LIMBS, NOTHING_GIVEN, limbs_by_name

ALIKE = 1e-3  # of the body's size: poses whose joints are nearer are the same
SYMMETRIC = 0.02  # of the body's size: a pose made to bind a mesh to is symmetric, and a moment of a motion is not


def without_frame_as_bind(scene: Scene) -> Scene:
    """Replaces a bind pose that is a frame of the motion by the pose in which the axes of all joints are parallel.

    Exporters write the moment of the export as the pose at rest if an animation has no mesh. It differs from file to
    file, so clips of one rig would have different bind poses. The axes of the joints are those of the rig.
    """
    found = limbs_by_name(scene.names, NOTHING_GIVEN)
    at = scene.bind[..., 3]
    if len(scene.world) < 2 or not set(LIMBS) <= set(found) or _symmetric(at[[found[role] for role in LIMBS]]):
        return scene
    apart = np.abs(scene.world[..., 3] - at).max(axis=(1, 2)).min()
    if apart > ALIKE * np.ptp(at, axis=0).max():
        return scene
    bind = np.zeros_like(scene.bind)
    bind[..., :3] = np.eye(3)
    for node, parent in enumerate(scene.parents.tolist()):
        bind[node, :, 3] = at[node]
        if parent >= 0:
            axes = scene.bind[parent, :, :3]
            turned = axes / np.maximum(np.linalg.norm(axes, axis=0), 1e-12)
            bind[node, :, 3] = bind[parent, :, 3] + turned.T @ (at[node] - at[parent])
    note = "its pose at rest is a frame of the motion; the axes of its joints are taken as bind pose instead"
    return replace(scene, bind=bind, notes=(*scene.notes, note))


def _symmetric(limbs: Floats) -> bool:
    """Returns whether a pose looks the same with left and right exchanged; limbs [n, 3], left and right in turns."""
    sides = np.arange(len(limbs)) ^ 1
    apart = np.linalg.norm(limbs[:, None] - limbs, axis=-1)
    return bool(np.abs(apart - apart[np.ix_(sides, sides)]).max() < SYMMETRIC * apart.max())
