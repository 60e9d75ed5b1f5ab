"""An additive aim offset, as game engines offer it: the baseline that look and aim are compared with.

Yaw and pitch from the heading to the target choose poses that were made for a person who stands straight. What these
add to straight ahead is laid on the motion, in the frame of the character (Unreal calls it mesh-space additive): each
joint of the chain turns by the same part, and what hangs on it goes along. The motion's own sway stays.
"""

from __future__ import annotations

import numpy as np

from bench.characters.aimed import UP, Shown, in_heading, of_motion
from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.stage import Stage

LEFT = [1.0, 0.0, 0.0]


def offset(stage: Stage, clip: Shown, end: int, vectors: Floats) -> Shown:
    """Returns the motion with an aim offset toward a target, on the joints from the pelvis to joint `end`.

    Args:
        stage: Knows the rig.
        clip: F frames.
        end: The last joint of the chain, which turns by the whole offset.
        vectors: [F, 3], from the character to the target in the world.
    """
    skeleton = stage.bank.skeleton
    chain = skeleton.chain(end)[::-1]
    chain = chain[chain.index(stage.bank.roles.pelvis) :]
    x, y, z = in_heading(clip, vectors).T
    yaw, pitch = np.arctan2(x, z), np.arctan2(y, np.hypot(x, z))
    rotations, above = clip.rotations.copy(), np.broadcast_to([0.0, 0.0, 0.0, 1.0], clip.rotations[:, 0].shape)
    for number, joint in enumerate(chain, 1):
        part = number / len(chain)
        local = quaternion.multiply(quaternion.about(UP, part * yaw), quaternion.about(LEFT, -part * pitch))
        turn = quaternion.multiply(
            quaternion.multiply(quaternion.about(UP, clip.headings), local), quaternion.about(UP, -clip.headings)
        )
        parent = quaternion.multiply(above, clip.world[:, skeleton.parents[joint]])
        world = quaternion.multiply(turn, clip.world[:, joint])
        rotations[:, joint] = quaternion.multiply(quaternion.conjugate(parent), world)
        above = turn
    return of_motion(stage, clip.roots, rotations, clip.headings)
