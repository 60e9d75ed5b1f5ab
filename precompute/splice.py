"""Whole-clip splicing: the papers' method, and plain DOF replacement to compare with.

`splice_exact` is the reference that tests and benchmarks compare the run-time splices with. Sources: Heck, Kovar and
Gleicher 2006, section 3; Heck's thesis, section 4.2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError, SkeletonError
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.parts import TRUNK, part_of_joint
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.alignment import SHORTEST_CLIP
from motionsplice.precompute.alignment.timewarp import TimeWarp, align_pair
from motionsplice.precompute.alignment.working_rate import WORKING_RATE
from motionsplice.precompute.body.posture import Torso, measure_torso
from motionsplice.runtime.format.standing import Standing

Posture = Literal["relative", "absolute", "off"]


@dataclass(frozen=True, eq=False)
class WholeClipSplice:
    """A spliced clip, and the time alignment that it was made with.

    Attributes:
        clip: The result, F frames at the locomotion's rate. It ends where the time alignment ends.
        action_frames: [F] The real-valued action frame under each frame of the result.
        warp: The time alignment of the two clips.
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
) -> WholeClipSplice:
    """Splices the action's upper body onto the locomotion's root and lower body, by the papers' three steps.

    The steps are time alignment, spatial alignment and posture transfer (Heck, Kovar and Gleicher 2006, 3.1 to 3.3).

    Args:
        locomotion: The clip that gives the root and the lower body.
        action: The clip that gives the upper body. It has the locomotion's skeleton.
        roles: Which joint of the skeleton is which.
        posture: What posture transfer does. `absolute` gives the result the action's mean posture (3.3). `relative`
            adds, frame by frame, what the action's torso does beyond its gait (docs/method.md). `off` does nothing.
        torso_offsets: The torso offsets [F, 4] of the locomotion and of the action, quaternions (x, y, z, w) at each
            clip's own frames (`Bank.torso`, or `precompute.preparation.torso_offset`). Only posture `relative` uses
            them. None for a clip that is its own neutral, for example a plain locomotion.

    Returns:
        The spliced clip, its action frames and the time alignment.

    Raises:
        SkeletonError: The clips have different joints.
        ClipError: The clips are too long or too short to be aligned, or the hips of a frame show no facing direction.
    """
    check_same_rig(locomotion, action)
    warp, action_frames = align_in_time(locomotion, action, roles)
    covered = locomotion.frames(0, len(action_frames))
    torso_l, torso_u = measure_torso(covered, roles), measure_torso(action, roles)
    positions_u, rotations_u = action.sampled(action_frames)
    sampled = measure_torso(Clip(action.name, action.skeleton, locomotion.rate, positions_u, rotations_u), roles)
    result = attach(covered, rotations_u, horn_rotation(torso_l.clouds, sampled.clouds), roles)
    if posture == "absolute":
        turn = horn_rotation(torso_u.posture, measure_torso(result, roles).posture)
        result = transfer_posture(result, torso_l, turn, roles)
    elif posture == "relative":
        offsets_l = sampled_offsets(torso_offsets[0], np.arange(float(covered.frame_count)))
        offsets_u = sampled_offsets(torso_offsets[1], action_frames)
        turn = quaternion.multiply(offsets_u, quaternion.conjugate(offsets_l))
        result = transfer_posture(result, torso_l, turn, roles)
    return WholeClipSplice(result, action_frames, warp)


def splice_standing(locomotion: Clip, action: Clip, roles: Roles, standing: Standing, *, start: float = 0.0) -> Clip:
    """Lays an action without a gait on a locomotion, at the action's own speed (docs/method.md).

    Each joint adds the action's departure from its stance to the locomotion's own rotation, so at a stance nothing of
    the locomotion changes. A part's usage weight takes it from there to the action's own rotation.

    Args:
        locomotion: The clip that gives the root, the lower body and the carriage of the torso.
        action: The standing action. It has the locomotion's skeleton.
        roles: Which joint of the skeleton is which.
        standing: How the action departs from its stance, at its own frames (`Bank.standing`).
        start: Seconds into the action at which it begins.

    Returns:
        A clip of the locomotion's length and rate. After the action's last frame it holds this frame.

    Raises:
        SkeletonError: The clips have different joints.
        ClipError: The hips of a frame show no facing direction.
    """
    check_same_rig(locomotion, action)
    frames = (start + np.arange(locomotion.frame_count) / locomotion.rate) * action.rate
    posed = action.sampled(np.minimum(frames, action.frame_count - 1.0))[1]
    usage = quaternion.interpolated(standing.usage, frames)
    rotations, parts = locomotion.rotations.copy(), part_of_joint(locomotion.skeleton, roles)
    for joint in locomotion.skeleton.subtree(roles.pelvis):
        if joint != roles.pelvis and standing.parts >> parts[joint] & 1:
            departure = quaternion.multiply(quaternion.conjugate(standing.stance[joint]), posed[:, joint])
            added = quaternion.multiply(locomotion.rotations[:, joint], departure)
            rotations[:, joint] = _nearer(added, posed[:, joint], usage[:, parts[joint]])
    result = replace(locomotion, name=f"{locomotion.name}+{action.name}", rotations=rotations)
    if not standing.parts & TRUNK:
        return result
    turns = sampled_offsets(standing.turns, frames)
    return transfer_posture(result, measure_torso(locomotion, roles), turns, roles)


def _nearer(a: Floats, b: Floats, share: Floats) -> Floats:
    """Returns rotations [F, 4] a `share` [F] of the way from a to b along the shorter arc, as a normalised mean."""
    near = np.where(np.sum(a * b, axis=-1) >= 0.0, share, -share)[:, None]
    return quaternion.normalise((1.0 - share[:, None]) * a + near * b)


def splice_naive(locomotion: Clip, action: Clip, roles: Roles) -> Clip:
    """Replaces the locomotion's upper-body rotations by the action's at the same time (plain DOF replacement).

    Nothing is aligned. An action shorter than the locomotion is repeated from its start.

    Args:
        locomotion: The clip that gives the root and the lower body.
        action: The clip that gives the upper body. It has the locomotion's skeleton.
        roles: Which joint of the skeleton is which.

    Returns:
        A clip of the locomotion's length and rate.

    Raises:
        SkeletonError: The clips have different joints.
    """
    check_same_rig(locomotion, action)
    seconds = np.arange(locomotion.frame_count) / locomotion.rate
    frames = np.mod(seconds, action.duration) * action.rate if action.frame_count > 1 else seconds * 0.0
    upper = locomotion.skeleton.subtree(roles.pelvis)
    rotations = locomotion.rotations.copy()
    rotations[:, upper] = action.sampled(frames)[1][:, upper]
    return replace(locomotion, name=f"{locomotion.name}+{action.name}", rotations=rotations)


def align_in_time(locomotion: Clip, action: Clip, roles: Roles) -> tuple[TimeWarp, Floats]:
    """Aligns the action to the locomotion in time (Heck et al. 2006, 3.1).

    Returns the alignment, and the action frames lambda(t) [F] at the locomotion's own frames, up to where the alignment
    ends. Raises ClipError if it ends before SHORTEST_CLIP seconds, or if the clips are too long for `align_pair`.
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
        f"it is in step with {locomotion.name!r} for less than {SHORTEST_CLIP} s before one of the clips ends",
        place=f"clip {action.name!r}",
        mend="Use the bank's splice (--method splice), which repeats the action",
    )


def attach(locomotion: Clip, rotations_u: Floats, q_a: Floats, roles: Roles) -> Clip:
    """Puts upper-body rotations [F, J, 4] on the locomotion, with the pelvis at q_P^L q_A (3.2); `q_a` is [F, 4]."""
    upper = locomotion.skeleton.subtree(roles.pelvis)
    rotations = locomotion.rotations.copy()
    rotations[:, upper] = rotations_u[:, upper]
    rotations[:, roles.pelvis] = quaternion.multiply(locomotion.rotations[:, roles.pelvis], q_a)
    return replace(locomotion, rotations=rotations)


def transfer_posture(splice: Clip, torso_l: Torso, turn: Floats, roles: Roles) -> Clip:
    """Turns the pelvis by q_G: the rotation `turn` [4] or [F, 4], given in the posture frame (3.3, docs/method.md)."""
    q_g = quaternion.multiply(quaternion.multiply(torso_l.frames, turn), quaternion.conjugate(torso_l.frames))
    rotations = splice.rotations.copy()
    rotations[:, roles.pelvis] = quaternion.multiply(q_g, splice.rotations[:, roles.pelvis])
    return replace(splice, rotations=rotations)


def sampled_offsets(offsets: Floats | None, frames: Floats) -> Floats:
    """Returns torso offsets [F, 4] sampled at real-valued frames [n]; identities if `offsets` is None."""
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
            mend="Bring both to one skeleton first, as building a bank does",
        )
