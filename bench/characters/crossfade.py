"""A change of locomotion as engines make it by default, a plain crossfade: the baseline that changes are compared with.

Both clips play at their own speed, the second from its start. Local rotations are blended along the shorter arc; roots
and root motion are blended by the same weight. Nothing keeps the clips in step, and no foot is held.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bench.characters.joint_speeds import RATE, pose_positions
from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.format.contacts import which_stand
from motionsplice.runtime.format.entries import ClipEntry
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage

UP = [0.0, 1.0, 0.0]


class Played(NamedTuple):
    """A clip in F frames, relative to its root path.

    Attributes:
        roots: [F, 3] metres, in the frame of the path.
        rotations: [F, J, 4], the root's in the frame of the path.
        steps: [F, 4], along the path to the next frame, in the frame of the path: metres, and the turn in radians.
        stands: [F, 2], whether the left and the right foot stand.
    """

    roots: Floats
    rotations: Floats
    steps: Floats
    stands: Floats


def crossfade(stage: Stage, first: ClipEntry, second: ClipEntry, time: float, shares: Floats) -> tuple[Floats, Floats]:
    """Returns places [F, J, 3] of the joints and the shares [F, 2] of the clips in which each foot stands.

    Args:
        stage: Evaluates the clips.
        first: The clip that plays first.
        second: The clip that follows. It begins when its share is first above 0.
        time: Seconds into the first clip at which it begins.
        shares: [F], the second clip's share in each frame.
    """
    frames = np.arange(len(shares))
    begins = int(np.argmax(shares > 0.0))
    one = played(stage, first, time + frames / RATE)
    other = played(stage, second, np.maximum(frames - begins, 0) / RATE)
    poses, share = stage.evaluator.poses(len(shares)), shares[:, None]
    steps = (1.0 - share) * one.steps + share * other.steps
    headings = np.concatenate([[0.0], np.cumsum(steps[:-1, 3])])
    turns = quaternion.about(UP, headings)
    places = np.cumsum(np.vstack([np.zeros(3), quaternion.rotate(turns, steps[:, :3])[:-1]]), axis=0)
    poses.root_positions[:] = places + quaternion.rotate(turns, (1.0 - share) * one.roots + share * other.roots)
    near = np.where((one.rotations * other.rotations).sum(axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    rotations = quaternion.unit((1.0 - share[..., None]) * one.rotations + share[..., None] * near * other.rotations)
    rotations[:, 0] = quaternion.multiply(turns, rotations[:, 0])
    poses.rotations[:] = rotations
    return pose_positions(stage, poses), (1.0 - share) * one.stands + share * other.stands


def played(stage: Stage, clip: ClipEntry, times: Floats) -> Played:
    """Returns what a clip shows at times [F]; after its end it holds its last frame."""
    bank, last = stage.bank, clip.frame_count - 1
    frames = np.minimum(np.append(times, times[-1] + 1.0 / RATE) * clip.rate, last)
    before = np.minimum(frames.astype(np.int64), max(last - 1, 0))
    path, bits = bank.root_path(clip.name), bank.tables["contacts"][clip.first_row + frames[:-1].astype(np.int64)]
    at = path[before] + (frames - before)[:, None] * (path[np.minimum(before + 1, last)] - path[before])
    back = quaternion.about(UP, -at[:-1, 3])
    poses = stage.evaluator.sequence(Splice(clip.name), frames[:-1] / clip.rate)
    rotations = poses.rotations.astype(np.float64)
    rotations[:, 0] = quaternion.multiply(back, rotations[:, 0])
    steps = np.diff(at, axis=0)
    steps[:, :3] = quaternion.rotate(back, steps[:, :3])
    roots = quaternion.rotate(back, poses.root_positions - at[:-1, :3])
    return Played(roots, rotations, steps, which_stand(bits).astype(float))
