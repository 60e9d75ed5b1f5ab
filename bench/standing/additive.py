"""Additive blending, as game engines offer it: the baseline that standing actions are compared with.

The action's local rotations relative to a reference pose are laid on the locomotion's, for all joints of the upper body
and at the action's own speed. Unreal calls it local-space additive, Unity an additive layer.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.roles import Roles


def add(locomotion: Clip, action: Clip, roles: Roles) -> Clip:
    """Returns the locomotion with the action added; the reference pose is the action's first frame, as in engines.

    The clips have one skeleton. After the action's last frame it holds this frame.
    """
    frames = np.arange(locomotion.frame_count) * action.rate / locomotion.rate
    posed = action.sampled(np.minimum(frames, action.frame_count - 1.0))[1]
    upper, rotations = locomotion.skeleton.subtree(roles.pelvis), locomotion.rotations.copy()
    departure = quaternion.multiply(posed[:, upper], quaternion.conjugate(action.rotations[0, upper]))
    rotations[:, upper] = quaternion.multiply(departure, rotations[:, upper])
    return replace(locomotion, name=f"{locomotion.name}+{action.name}", rotations=rotations)
