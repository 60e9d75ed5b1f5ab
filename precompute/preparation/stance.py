"""The stance of a standing action: the pose at rest from which its gesture departs, and how far each limb departs.

Engines subtract a reference pose in the same way for additive animation. Here the pose is found in the clip itself, and
a usage weight says where the action must replace the locomotion's pose, not add to it (docs/method.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import heading
from motionsplice.motion.parts import PART_NAMES, PARTS, UPPER_BODY, chains_to_limbs
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import SIDES, Roles
from motionsplice.precompute.body.joint_paths import joint_paths, joint_transforms
from motionsplice.runtime.format.standing import Standing

UP = np.array([0.0, 1.0, 0.0])
STILL = 0.035  # leg lengths: at rest no joint is farther than this from where it is in the clip's first or last frame
SHORTEST_REST = 0.2  # seconds
TURNS = 1.0  # radians: hips that turn farther from the way they face at rest turn the whole person
TURNING = 0.5  # seconds over which such a turn is smoothed
LEAST, MOST = 0.035, 0.35  # leg lengths from the stance: a limb that departs less is not used, one beyond is all used
SMOOTHING = 0.05  # seconds
ARM = ("wrist", "elbow", "shoulder")
NOTICEABLE, TURNED = 0.5, 0.17  # usage of an arm, and radians of trunk or head, that count as used


@dataclass(frozen=True, eq=False)
class Stance:
    """A pose at rest: local rotations [J, 4], and the pelvis's rotation [4] in a frame that faces as the hips do."""

    rotations: Floats
    pelvis: Floats

    @classmethod
    def of(cls, clip: Clip, frames: NDArray[np.int64], roles: Roles) -> Stance:
        """Returns the mean pose of a clip's frames [n]."""
        world = joint_transforms(clip, (roles.pelvis,))[1][frames, 0]
        faced = quaternion.multiply(quaternion.about(UP, -_facing(clip, roles)[frames]), world)
        return cls(_mean(clip.rotations[frames]), _mean(faced))


def rest_frames(clip: Clip, roles: Roles) -> NDArray[np.int64]:
    """Returns the frames at rest before and after the gesture [n]; none if the clip neither begins nor ends at rest.

    A clip begins at rest if it stays near its first pose for SHORTEST_REST, or if its arms hang in the same pose at
    both ends. If it is at rest at both ends, in different poses, only the one whose wrists are lower counts.
    """
    left, right = ((getattr(roles, f"{side}_{joint}") for joint in ARM) for side in SIDES)
    head = (joint for joint in (roles.neck, roles.head) if joint >= 0)
    paths = joint_paths(clip, (roles.pelvis, *left, *right, *head))
    turn = quaternion.about(UP, -_facing(clip, roles))[:, None]
    poses = quaternion.rotate(turn, paths[:, 1:] - paths[:, :1])
    still = STILL * roles.leg_length(clip.skeleton)
    same = np.linalg.norm(poses[0] - poses[-1], axis=-1).max() <= 2.0 * still
    heights = poses[[0, -1], :6, 1].reshape(2, 2, 3)
    shortest = 0.0 if same and (np.diff(heights) > 0.0).all() else SHORTEST_REST * clip.rate
    first, last = (
        lasting if lasting > shortest else 0 for lasting in (_lasting(poses, still), _lasting(poses[::-1], still))
    )
    if first and last and not same:
        lower = heights[0, :, 0].mean() <= heights[1, :, 0].mean()
        first, last = (first, 0) if lower else (0, last)
    frames = np.arange(clip.frame_count)
    return frames[(frames < first) | (frames >= clip.frame_count - last)]


def _lasting(poses: Floats, still: float) -> int:
    """Returns for how many frames [F, n, 3] no joint is farther than `still` from where it is in the first."""
    away = np.linalg.norm(poses - poses[0], axis=-1).max(axis=1) > still
    return int(np.argmax(away)) if away.any() else len(poses)


def departures(clip: Clip, stance: Stance, roles: Roles, rest: NDArray[np.int64]) -> Standing:
    """Measures how a clip [F] departs from a stance; `rest` [n] are the frames in which it is at rest."""
    return Standing(
        stance=stance.rotations,
        turns=_turns(clip, stance, roles, rest),
        usage=_usage(clip, stance, roles),
        parts=UPPER_BODY,
    )


def parts_used(clip: Clip, standing: Standing, roles: Roles, frames: slice = slice(None)) -> tuple[str, ...]:
    """Returns the names of the parts that depart noticeably from the stance in these frames."""
    turns = quaternion.angle(clip.rotations[frames], standing.stance)
    turns[:, roles.pelvis] = quaternion.angle(standing.turns[frames], quaternion.IDENTITY)
    turned = np.zeros(PARTS)
    turned[0] = turns[:, sorted({roles.pelvis, *roles.spine})].sum(axis=1).max()
    turned[-1] = turns[:, [joint for joint in (roles.neck, roles.head) if joint >= 0]].sum(axis=1).max(initial=0.0)
    used = (standing.usage[frames].max(axis=0) >= NOTICEABLE) | (turned >= TURNED)
    return tuple(name for name, one in zip(PART_NAMES, used, strict=True) if one)


def _facing(clip: Clip, roles: Roles) -> Floats:
    """Returns the heading [F] of the hips, radians about Y, unwrapped."""
    hips = joint_paths(clip, (roles.left_hip, roles.right_hip))
    return np.unwrap(heading(hips[:, 0] - hips[:, 1]))


def _turns(clip: Clip, stance: Stance, roles: Roles, rest: NDArray[np.int64]) -> Floats:
    """Returns how the pelvis is turned from the stance [F, 4], seen by a person who faces as at rest.

    So the hips' own turn in a punch counts as the action's. If the hips turn farther than TURNS, the person turns.
    """
    facing = _facing(clip, roles)
    ahead = np.interp(np.arange(len(facing)), rest, facing[rest]) if len(rest) else np.full(len(facing), facing.mean())
    if np.abs(facing - ahead).max() > TURNS:
        ahead = gaussian_filter1d(facing, TURNING * clip.rate, mode="nearest")
    world = joint_transforms(clip, (roles.pelvis,))[1][:, 0]
    faced = quaternion.multiply(quaternion.about(UP, -ahead), world)
    return quaternion.one_hemisphere(quaternion.multiply(faced, quaternion.conjugate(stance.pelvis)))


def _usage(clip: Clip, stance: Stance, roles: Roles) -> Floats:
    """Returns the usage weights [F, PARTS]: of the arms, by how far elbow and wrist are from the stance, on the chest.

    Trunk and head have none: what they do is always added to what they do in the locomotion.
    """
    weights, leg = np.zeros((clip.frame_count, PARTS)), roles.leg_length(clip.skeleton)
    chains = list(chains_to_limbs(clip.skeleton, roles).values())
    tips = ((roles.left_elbow, roles.left_wrist), (roles.right_elbow, roles.right_wrist))
    for part, joints in enumerate(tips, 1):
        if chain := chains[part - 1]:
            chest = int(clip.skeleton.parents[chain[-1]])
            own, still = (_seen_from(one, chest, joints) for one in (clip, _posed(clip, stance)))
            away = np.linalg.norm(own - still, axis=-1).max(axis=1) / leg
            share = np.clip((away - LEAST) / (MOST - LEAST), 0.0, 1.0)
            eased = share * share * (3.0 - 2.0 * share)
            weights[:, part] = gaussian_filter1d(eased, SMOOTHING * clip.rate, mode="nearest")
    return weights


def _posed(clip: Clip, stance: Stance) -> Clip:
    """Returns a clip of one frame, in the stance."""
    return Clip(clip.name, clip.skeleton, clip.rate, np.zeros((1, 3)), stance.rotations[None])


def _seen_from(clip: Clip, joint: int, joints: tuple[int, ...]) -> Floats:
    """Returns the positions [F, n, 3] of joints in the frame of another joint, metres."""
    positions, world = joint_transforms(clip, (joint, *joints))
    return quaternion.rotate(quaternion.conjugate(world[:, :1]), positions[:, 1:] - positions[:, :1])


def _mean(rotations: Floats) -> Floats:
    """Returns the mean [..., 4] of rotations [n, ..., 4] that are near each other."""
    return quaternion.normalise(quaternion.one_hemisphere(rotations).sum(axis=0))
