"""Whole-clip splicing: the papers' method, and the naive one. All run-time forms are judged by it.

Heck, Kovar and Gleicher 2006, section 3; Heck's thesis, 4.2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError, SkeletonError
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.baseline import SHORTEST_CLIP, WORKING_RATE
from motionsplice.precompute.alignment.timewarp import TimeWarp, align_pair
from motionsplice.precompute.body.posture import Torso, measure_torso

Posture = Literal["relative", "absolute", "off"]


@dataclass(frozen=True, eq=False)
class Splice:
    """A spliced clip, which ends where the time alignment ends, and the time alignment it was made with.

    action_frames: [F] the real-valued action frame under each frame of the result.
    """

    clip: Clip
    action_frames: Floats
    warp: TimeWarp


def splice_exact(
    locomotion: Clip,
    action: Clip,
    roles: Roles,
    *,
    posture: Posture = "relative",
    torso_offsets: tuple[Floats | None, Floats | None] = (None, None),
) -> Splice:
    """The action's upper body on the locomotion's root and lower body, by the papers' three steps.

    All clips share one skeleton. Posture `relative` needs the `torso_offsets` [F, 4] of locomotion and action at their
    own frames (`precompute.preparation.torso_offset`, `Bank.torso`); None for a clip that is its own neutral, as a
    plain locomotion is (docs/method.md). Raises SkeletonError for clips on two skeletons, and ClipError for clips too
    long or too short to be aligned.
    """
    check_same_rig(locomotion, action)
    warp, action_frames = align_in_time(locomotion, action, roles)
    kept = locomotion.frames(0, len(action_frames))
    torso_l, torso_u = measure_torso(kept, roles), measure_torso(action, roles)
    positions_u, rotations_u = action.sampled(action_frames)
    sampled = measure_torso(Clip(action.name, action.skeleton, locomotion.rate, positions_u, rotations_u), roles)
    result = attach(kept, rotations_u, horn_rotation(torso_l.clouds, sampled.clouds), roles)
    if posture == "absolute":
        turn = horn_rotation(torso_u.posture, measure_torso(result, roles).posture)
        result = transfer_posture(result, torso_l, turn, roles)
    elif posture == "relative":
        own = sampled_offsets(torso_offsets[0], np.arange(float(kept.frame_count)))
        theirs = sampled_offsets(torso_offsets[1], action_frames)
        result = transfer_posture(result, torso_l, quaternion.multiply(theirs, quaternion.conjugate(own)), roles)
    return Splice(result, action_frames, warp)


def splice_naive(locomotion: Clip, action: Clip, roles: Roles) -> Clip:
    """Plain DOF replacement: at each moment the action's upper-body rotations, the action repeated as needed."""
    check_same_rig(locomotion, action)
    seconds = np.arange(locomotion.frame_count) / locomotion.rate
    frames = np.mod(seconds, action.duration) * action.rate if action.frame_count > 1 else seconds * 0.0
    upper = locomotion.skeleton.subtree(roles.pelvis)
    rotations = locomotion.rotations.copy()
    rotations[:, upper] = action.sampled(frames)[1][:, upper]
    return replace(locomotion, name=f"{locomotion.name}+{action.name}", rotations=rotations)


def align_in_time(locomotion: Clip, action: Clip, roles: Roles) -> tuple[TimeWarp, Floats]:
    """lambda(t) at the locomotion's own frames, up to where the alignment ends (Heck et al. 2006, 3.1).

    Raises ClipError if that is before SHORTEST_CLIP, or if the clips are too long for `align_pair`.
    """
    cloud = list(roles.lower_cloud)
    if min(locomotion.duration, action.duration) < SHORTEST_CLIP:
        raise _too_short(locomotion, action)
    clouds_l, clouds_u = (joint_positions(clip.resampled(WORKING_RATE))[:, cloud] for clip in (locomotion, action))
    warp = align_pair(clouds_l, clouds_u, WORKING_RATE)
    covered = warp.path[-1, 0] / WORKING_RATE
    if covered < SHORTEST_CLIP:
        raise _too_short(locomotion, action)
    at = np.arange(int(covered * locomotion.rate + 1e-9) + 1) * (WORKING_RATE / locomotion.rate)
    return warp, np.asarray(warp.curve(at)) * (action.rate / WORKING_RATE)


def _too_short(locomotion: Clip, action: Clip) -> ClipError:
    return ClipError(
        f"it goes in step with {locomotion.name!r} for less than {SHORTEST_CLIP} s before one of them ends",
        place=f"clip {action.name!r}",
        mend="Use the bank's splice (--method splice), which repeats the action",
    )


def attach(locomotion: Clip, rotations_u: Floats, q_a: Floats, roles: Roles) -> Clip:
    """Upper-body rotations [F, J, 4] on the locomotion, the pelvis turned by q_P^L q_A (3.2). q_a is [F, 4]."""
    upper = locomotion.skeleton.subtree(roles.pelvis)
    rotations = locomotion.rotations.copy()
    rotations[:, upper] = rotations_u[:, upper]
    rotations[:, roles.pelvis] = quaternion.multiply(locomotion.rotations[:, roles.pelvis], q_a)
    return replace(locomotion, rotations=rotations)


def transfer_posture(splice: Clip, torso_l: Torso, turn: Floats, roles: Roles) -> Clip:
    """The pelvis turned by q_G, which is `turn` [4] or [F, 4] as seen in the posture frame (3.3, docs/method.md)."""
    seen = quaternion.multiply(quaternion.multiply(torso_l.frames, turn), quaternion.conjugate(torso_l.frames))
    rotations = splice.rotations.copy()
    rotations[:, roles.pelvis] = quaternion.multiply(seen, splice.rotations[:, roles.pelvis])
    return replace(splice, rotations=rotations)


def sampled_offsets(offsets: Floats | None, frames: Floats) -> Floats:
    """Torso offsets [F, 4] at real-valued frames [n]; identities for a clip that is its own neutral."""
    if offsets is None:
        return np.broadcast_to(quaternion.IDENTITY, (len(frames), 4))
    before, after, t = quaternion.neighbours(len(offsets), frames)
    return quaternion.slerp(offsets[before], offsets[after], t)


def check_same_rig(locomotion: Clip, action: Clip) -> None:
    """Raises SkeletonError unless both clips have the same joints in the same order."""
    a, b = locomotion.skeleton, action.skeleton
    if a.names != b.names or not np.array_equal(a.parents, b.parents):
        raise SkeletonError(
            f"clips {locomotion.name!r} and {action.name!r} have different joints",
            mend="Bring both to one skeleton first: a bank does so",
        )
