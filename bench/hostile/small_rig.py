"""A clip on a rig of few joints, of which small files are made."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.skeleton import Skeleton

LEFT_OUT = ("Spine1", "Spine2", "Neck", "LeftShoulder", "RightShoulder", "LeftToeBase", "RightToeBase")


def on_few_joints(clip: Clip) -> Clip:
    """Returns a built-in clip without the joints that a reader can do without; the bones around them are straight."""
    whole = clip.skeleton
    kept = [joint for joint in range(whole.joint_count) if whole.names[joint] not in LEFT_OUT]
    nearest, reach = np.arange(whole.joint_count), np.zeros((whole.joint_count, 3))  # the kept joint above, and from it
    for joint, name in enumerate(whole.names):
        if name in LEFT_OUT:
            above = int(whole.parents[joint])
            nearest[joint], reach[joint] = nearest[above], reach[above] + whole.offsets[joint]
    places = {joint: place for place, joint in enumerate(kept)}
    over, ends = whole.parents[kept], whole.end_parents
    skeleton = Skeleton(
        names=tuple(whole.names[joint] for joint in kept),
        parents=np.array([-1, *(places[int(joint)] for joint in nearest[over[1:]])]),
        offsets=whole.offsets[kept] + reach[np.maximum(over, 0)],
        end_parents=np.array([places[int(joint)] for joint in nearest[ends]]),
        end_offsets=whole.end_offsets + reach[ends],
    )
    return Clip(clip.name, skeleton, clip.rate, clip.root_positions, clip.rotations[:, kept])
