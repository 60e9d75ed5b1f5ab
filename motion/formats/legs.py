"""Legs that hang on other joints than those that they follow.

3ds Max's Biped hangs hips on the first joint of the spine, although they follow the pelvis. Rigs that are posed by IK
hang feet on the root, although they stay at the end of the shins. A skeleton has fixed offsets, so it needs the joints
that are followed as parents.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.formats.scene import Scene
from motionsplice.motion.formats.transforms import rotations_of
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import NOTHING_GIVEN, limbs_by_name
from motionsplice.motion.skeleton import Integers, chain

STEADY = 0.01  # of the thigh: a joint that moves less on another joint is fixed to it
STRETCH = 0.2  # of the thigh: IK may stretch a leg in some frames, and the foot then leaves the end of the shin


def with_legs_in_place(scene: Scene) -> tuple[Scene, Integers]:
    """Hangs hips and feet on the joints that they follow, and notes it. Returns also where each node was before [N]."""
    unchanged = np.arange(len(scene.names))
    joints = np.flatnonzero(scene.joints)
    found = limbs_by_name(tuple(scene.names[joint] for joint in joints), NOTHING_GIVEN)
    legs = {role: int(joints[place]) for role, place in found.items() if role.endswith(("hip", "knee", "ankle"))}
    if not {"left_hip", "right_hip", "left_knee", "right_knee"} <= set(legs):
        return scene, unchanged
    thigh = float(np.linalg.norm(scene.world[0, legs["left_knee"], :, 3] - scene.world[0, legs["left_hip"], :, 3]))
    moves = _hips(scene, legs, thigh) | _feet(scene, legs, thigh)
    if not moves:
        return scene, unchanged
    names = [f"{scene.names[joint]!r} on {scene.names[parent]!r}" for joint, parent in moves.items()]
    return _rehung(
        replace(scene, notes=(*scene.notes, f"hung on the joint that it follows: {', '.join(names)}")), moves
    )


def _hips(scene: Scene, legs: Mapping[str, int], thigh: float) -> dict[int, int]:
    """Returns the parent of the spine's first joint as new parent of both hips, if they hang on that joint."""
    hips = [legs["left_hip"], legs["right_hip"]]
    spine, other = scene.parents[hips].tolist()
    pelvis = int(scene.parents[spine]) if spine >= 0 else -1
    if spine != other or "spine" not in scene.names[spine].lower() or pelvis < 0 or not scene.joints[pelvis]:
        return {}
    steady = all(np.ptp(_on(scene, hip, pelvis), axis=0).max() <= STEADY * thigh for hip in hips)
    return dict.fromkeys(hips, pelvis) if steady else {}


def _feet(scene: Scene, legs: Mapping[str, int], thigh: float) -> dict[int, int]:
    """Returns the knee as new parent of each foot that hangs elsewhere and is mostly near the end of the shin."""
    found = {}
    for side in ("left", "right"):
        knee, ankle = legs[f"{side}_knee"], legs.get(f"{side}_ankle", -1)
        if ankle >= 0 and knee not in chain(scene.parents, ankle):
            places = _on(scene, ankle, knee)
            off = np.linalg.norm(places - np.median(places, axis=0), axis=1)
            if np.median(off) <= STRETCH * thigh:
                found[ankle] = knee
    return found


def _on(scene: Scene, joint: int, other: int) -> Floats:
    """Returns the positions [F, 3] of a joint as seen from another."""
    turns = rotations_of(scene.world[:, other])
    return quaternion.rotate(quaternion.conjugate(turns), scene.world[:, joint, :, 3] - scene.world[:, other, :, 3])


def _rehung(scene: Scene, moves: Mapping[int, int]) -> tuple[Scene, Integers]:
    """Returns the scene with other parents for some nodes, parent before child again, and where each was before."""
    parents = scene.parents.copy()
    parents[list(moves)] = list(moves.values())
    depths = [len(chain(parents, node)) for node in range(len(parents))]
    order = np.argsort(depths, kind="stable") if np.any(parents >= np.arange(len(parents))) else np.arange(len(parents))
    places = np.argsort(order)
    hung = replace(
        scene,
        names=tuple(scene.names[node] for node in order),
        parents=np.where(parents[order] < 0, -1, places[parents[order]]),
        joints=scene.joints[order],
        bind=scene.bind[order],
        world=scene.world[:, order],
    )
    return hung, order
