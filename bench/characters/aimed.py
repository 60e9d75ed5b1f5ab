"""The poses of a character with an action, and where its head and its hands point."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bench.characters.joint_speeds import RATE
from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.stage import Stage

FRAMES, SETTLED = 300, 60  # of each measurement; those that are left out at its beginning
AHEAD = [0.0, 0.0, 1.0]
UP = [0.0, 1.0, 0.0]
WITHIN = np.radians(60.0)  # of the heading

Tell = Callable[[Characters], None]


class Shown(NamedTuple):
    """The poses of a character in F frames.

    Attributes:
        roots: [F, 3], metres.
        rotations: [F, J, 4].
        places: [F, J, 3], of the joints in the world.
        world: [F, J, 4], rotations in the world.
        headings: [F], radians.
    """

    roots: Floats
    rotations: Floats
    places: Floats
    world: Floats
    headings: Floats


def of_motion(stage: Stage, roots: Floats, rotations: Floats, headings: Floats) -> Shown:
    """Returns what is shown by roots [F, 3] and rotations [F, J, 4]."""
    return Shown(roots, rotations, *world_transforms(stage.bank.skeleton, roots, rotations), headings)


def shown(stage: Stage, locomotion: str, action: str, tell: Tell, method: Any = "splice") -> Shown:
    """Plays a locomotion with an action."""
    characters, poses = Characters(stage, RATE), stage.evaluator.poses(1)
    characters.add(1, locomotion)
    characters.act([0], Action(action, blend=0.0, method=method))
    tell(characters)
    roots, rotations, headings = [], [], []
    for _ in range(FRAMES):
        characters.evaluate(poses)
        roots.append(poses.root_positions[0].astype(np.float64))
        rotations.append(poses.rotations[0].astype(np.float64))
        headings.append(characters.state[0, col.HEADING])
        characters.advance()
    return of_motion(stage, np.array(roots), np.array(rotations), np.array(headings))


def nothing(characters: Characters) -> None:
    """Tells characters nothing."""


def degrees_apart(a: Floats, b: Floats) -> Floats:
    """Returns the angles [...] between vectors [..., 3]."""
    apart = quaternion.length(quaternion.unit(a) - quaternion.unit(b))
    return np.asarray(np.degrees(2.0 * np.arcsin(np.minimum(0.5 * apart, 1.0))))


def in_heading(clip: Shown, vectors: Floats) -> Floats:
    """Returns vectors [F, 3] of the world in the frame of the heading."""
    return np.asarray(quaternion.rotate(quaternion.about(UP, -clip.headings), vectors))


def gazes(stage: Stage, clip: Shown) -> Floats:
    """Returns which way the head looks in each frame [F, 3]."""
    return quaternion.rotate(clip.world[:, stage.bank.roles.head], stage.arrays.chains.gaze)


def is_within(clip: Shown, vectors: Floats) -> Any:
    """Returns in which frames [F] vectors [F, 3] to a target are settled and within the limits."""
    turned = in_heading(clip, vectors)
    within = np.abs(np.arctan2(turned[:, 0], turned[:, 2])) < WITHIN
    level = np.abs(np.arctan2(turned[:, 1], np.hypot(turned[:, 0], turned[:, 2])))
    return within & (level < 0.5) & (np.arange(len(vectors)) >= SETTLED)


def yaws(stage: Stage, clip: Shown) -> Floats:
    """Returns the yaw [F] of the middle of both hands, seen from the hips, radians from the heading."""
    roles = stage.bank.roles
    to = 0.5 * (clip.places[:, roles.left_wrist] + clip.places[:, roles.right_wrist]) - clip.places[:, 0]
    turned = in_heading(clip, to)
    return np.asarray(np.unwrap(np.arctan2(turned[:, 0], turned[:, 2])))


def swivel(stage: Stage, clip: Shown, *, aimed: bool = False) -> float:
    """Returns the standard deviation of the hands' yaw, degrees, from the heading or from what they are aimed at."""
    from_heading = yaws(stage, clip)
    if aimed:
        within = is_within(clip, np.broadcast_to(AHEAD, (FRAMES, 3)))
        return float(np.degrees(np.std((from_heading + clip.headings)[within]))) if within.any() else 0.0
    return float(np.degrees(np.std(from_heading[SETTLED:])))
