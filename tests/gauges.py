"""Measurements on clips of the built-in humanoid: joint angles, soles on the ground, lean, speed."""

from __future__ import annotations

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import end_positions, joint_positions, world_transforms
from motionsplice.motion.procedural.body import HEEL, SKELETON
from motionsplice.motion.quaternion import Floats

RATE = 100.0
SIDES = ("Left", "Right")


def at(clip: Clip, name: str) -> Floats:
    return joint_positions(clip)[:, SKELETON.index(name)]


def bend(clip: Clip, upper: str, middle: str, lower: str) -> Floats:
    """Degrees [F] by which a limb is bent; 0 is straight."""
    first = at(clip, middle) - at(clip, upper)
    second = at(clip, lower) - at(clip, middle)
    cosine = np.sum(first * second, axis=-1) / np.linalg.norm(first, axis=-1) / np.linalg.norm(second, axis=-1)
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def knee(clip: Clip, side: str) -> Floats:
    return bend(clip, side + "UpLeg", side + "Leg", side + "Foot")


def heading(clip: Clip) -> Floats:
    """Unit vectors [F, 3] in the floor plane: the direction that the pelvis faces."""
    facing = quaternion.rotate(clip.rotations[:, 0], [0.0, 0.0, 1.0]) * [1.0, 0.0, 1.0]
    return np.asarray(facing / np.linalg.norm(facing, axis=-1, keepdims=True))


def ahead(clip: Clip, name: str, of: str = "Hips") -> Floats:
    """Metres [F] by which one joint is ahead of another, in the direction that the pelvis faces."""
    return np.asarray(np.sum((at(clip, name) - at(clip, of)) * heading(clip), axis=-1))


def soles(clip: Clip, side: str) -> tuple[Floats, Floats, Floats]:
    """World positions [F, 3] of heel, ball and the tip of the toes."""
    positions, world = world_transforms(SKELETON, clip.root_positions, clip.rotations)
    foot, toe = SKELETON.index(side + "Foot"), SKELETON.index(side + "ToeBase")
    heel = positions[:, foot] + quaternion.rotate(world[:, foot], [0.0, HEEL[1], HEEL[0]])
    tips = end_positions(SKELETON, positions, world)
    return heel, positions[:, toe], tips[:, SKELETON.end_parents.tolist().index(toe)]


def footholds(clip: Clip) -> Floats:
    """Positions [n, 3] of the ankles while a foot is flat on the ground, in order of Z."""
    placed = []
    for side in SIDES:
        foot = at(clip, side + "Foot")
        still = np.flatnonzero(np.linalg.norm(np.diff(foot, axis=0), axis=-1) * RATE < 0.02)
        for run in np.split(still, np.flatnonzero(np.diff(still) > 1) + 1):
            if len(run) > 10:
                placed.append(foot[run[len(run) // 2]])
    return np.array(sorted(placed, key=lambda place: float(place[2])))


def resting(clip: Clip, side: str) -> float:
    """The share of time during which the ball of a foot does not move."""
    return float(np.mean(np.linalg.norm(np.diff(soles(clip, side)[1], axis=0), axis=-1) * RATE < 0.05))


def leans(clip: Clip) -> Floats:
    """Forward lean of the trunk in degrees [F]."""
    return np.asarray(
        np.degrees(np.arctan2(ahead(clip, "Neck", "Spine"), (at(clip, "Neck") - at(clip, "Spine"))[:, 1]))
    )


def lean(clip: Clip) -> float:
    """Mean forward lean of the trunk in degrees."""
    return float(leans(clip).mean())


def speed(clip: Clip) -> float:
    """Mean metres per second along Z."""
    return float(np.diff(clip.root_positions[[0, -1], 2])[0] / (clip.frame_count - 1) * clip.rate)


def part(clip: Clip, start: float, end: float) -> Clip:
    """A clip from `start` to `end` seconds."""
    frames = slice(round(start * clip.rate), round(end * clip.rate))
    return Clip(clip.name, clip.skeleton, clip.rate, clip.root_positions[frames], clip.rotations[frames])


def period(curve: Floats) -> int:
    """The lag in frames, between 0.5 and 1.7 seconds, at which a curve repeats best."""
    lags = range(int(0.5 * RATE), int(1.7 * RATE))
    return min(lags, key=lambda lag: float(np.mean((curve[lag:] - curve[:-lag]) ** 2)))
