"""Additive blending, as game engines offer it: the baseline that standing actions are compared with.

The action's local rotations relative to a reference pose are laid on the locomotion's, for all joints of the upper body
and at the action's own speed. Unreal calls it local-space additive, Unity an additive layer.
"""

from __future__ import annotations

from dataclasses import replace

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.roles import Roles


def add(locomotion: Clip, replaced: Clip, roles: Roles) -> Clip:
    """Returns the locomotion with an action added; the reference pose is the action's first frame, as in engines.

    `replaced` is the locomotion with its upper body replaced by the action's, from the action's first frame on.
    """
    upper, rotations = locomotion.skeleton.subtree(roles.pelvis), locomotion.rotations.copy()
    posed = replaced.rotations[:, upper]
    departure = quaternion.multiply(posed, quaternion.conjugate(posed[0]))
    rotations[:, upper] = quaternion.multiply(departure, rotations[:, upper])
    return replace(locomotion, name=replaced.name, rotations=rotations)
