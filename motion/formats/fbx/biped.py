"""Rigs of 3ds Max's Biped, which hang the legs on the first joint of the spine, although they follow the pelvis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.formats.scene import Scene, rotations_of
from motionsplice.motion.roles import NOTHING_GIVEN, limbs_by_name

STEADY = 0.01  # of the thigh: a hip that moves less on a joint is fixed to it


def with_legs_on_the_pelvis(scene: Scene) -> Scene:
    """Hangs the legs on the parent of the spine's first joint if they hang on that joint but are fixed to its parent.

    When the spine bends, such hips move on their parent. A skeleton has fixed offsets, which would then be wrong by
    centimetres.
    """
    found = limbs_by_name(scene.names, NOTHING_GIVEN)
    if not {"left_hip", "right_hip", "left_knee"} <= set(found):
        return scene
    hips = [found["left_hip"], found["right_hip"]]
    spine, other = scene.parents[hips].tolist()
    pelvis = int(scene.parents[spine]) if spine >= 0 else -1
    if spine != other or "spine" not in scene.names[spine].lower() or pelvis < 0 or not scene.joints[pelvis]:
        return scene
    at = scene.world[..., 3]
    turns = rotations_of(scene.world[:, [pelvis]])
    places = quaternion.rotate(quaternion.conjugate(turns), at[:, hips] - at[:, [pelvis]])
    thigh = np.linalg.norm(at[0, found["left_knee"]] - at[0, hips[0]])
    if np.ptp(places, axis=0).max() > STEADY * thigh:
        return scene
    parents = scene.parents.copy()
    parents[hips] = pelvis
    note = f"the legs hang on {scene.names[pelvis]!r}, which they follow, not on {scene.names[spine]!r}"
    return replace(scene, parents=parents, notes=(*scene.notes, note))
