"""How fast joints must be to follow commands: cross-fades in which each joint turns by the shortest way.

A command gives its blend a duration. One that asks a hand to rise by a metre within 0.2 s asks for 7.5 m/s half-way,
however smooth the result is. The reference goes on without the slot that fades in, and with nothing but it, both
without feet locked and without targets, and turns each joint from the one to the other, by the smooth step that the
command asks for. It shares no code with the characters' own blends.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.characters.joint_speeds import RATE
from bench.characters.steady import LAYERS, LEGS, alone_of
from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.character_rows import States
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.aim import PARTS
from motionsplice.runtime.stage import Stage

UP = [0.0, 1.0, 0.0]
AT_ONCE = 2000  # cross-fades, to limit memory


class CrossFade(NamedTuple):
    """State rows without the slot that fades in and with nothing but it, and for how many seconds it fades in."""

    without: States
    whole: States
    lasting: float


def cross_fades(row: States) -> Iterator[CrossFade]:
    """Yields a cross-fade for each slot of a state row that has just begun to fade in."""
    plain = row.copy()
    plain[[col.NEXT_COUNT, col.WHEN, col.HANDS_WAIT, col.LOCK, col.LOCKED, col.AIMED]] = 0.0
    plain[[part + col.TARGET for part in PARTS.values()]] = col.NOTHING
    group = max((number for number in range(int(row[col.LOCOMOTIONS])) if row[LEGS[number] + col.HEAD]), default=0)
    if group > 0 and has_begun(row, LEGS[group]):
        without, whole = plain.copy(), alone_of(plain, group)
        without[col.LOCOMOTIONS], whole[LEGS[0] + col.LASTING] = group, 0.0
        shares = [slot + col.SHARE for slot in LEGS[:group]]
        without[shares] /= without[shares].sum()
        yield CrossFade(without, whole, row[LEGS[group] + col.LASTING])
    top = int(row[col.ACTIONS]) - 1
    if top >= 0 and has_begun(row, LAYERS[top]):
        without, whole = plain.copy(), plain.copy()
        without[col.ACTIONS], whole[LAYERS[top] + col.LASTING] = top, 0.0
        yield CrossFade(without, whole, row[LAYERS[top] + col.LASTING])


def has_begun(row: States, slot: int) -> bool:
    """Whether a slot began to fade in within the last frame."""
    return bool(row[slot + col.ELAPSED] < 1.5 / RATE < row[slot + col.LASTING])


def fastest_of_fades(stage: Stage, fades: Sequence[CrossFade]) -> NDArray[np.float64]:
    """Returns the speed of the fastest joint in each cross-fade [n], metres per second."""
    parts = [play(stage, fades[first : first + AT_ONCE]) for first in range(0, len(fades), AT_ONCE)]
    return np.concatenate([np.zeros(0), *parts])


def play(stage: Stage, fades: Sequence[CrossFade]) -> NDArray[np.float64]:
    """Plays cross-fades at the same time."""
    sides = [Characters(stage, RATE, np.array(rows)) for rows in list(zip(*fades, strict=True))[:2]]
    lasting = np.array([fade.lasting for fade in fades])
    fastest, now = np.zeros(len(fades)), mixed(sides, np.zeros(len(fades)))
    for frame in range(int(np.ceil(RATE * lasting.max()))):
        before, states, share = now, [one.state.copy() for one in sides], smooth((frame + 0.5) / RATE / lasting)
        for one in sides:
            one.advance()
        (shift, turn), (other_shift, other_turn) = (
            path_step(state, one.state) for state, one in zip(states, sides, strict=True)
        )
        turn, shift = turn + share * (other_turn - turn), shift + share[:, None] * (other_shift - shift)
        now = mixed(sides, smooth((frame + 1.0) / RATE / lasting))
        steps = quaternion.rotate(quaternion.about(UP, turn)[:, None], now) + shift[:, None] - before
        speed = RATE * np.linalg.norm(steps, axis=-1).max(axis=-1)
        np.maximum(fastest, speed * (frame < RATE * lasting), out=fastest)
    return fastest


def mixed(sides: Sequence[Characters], share: Floats) -> Floats:
    """Returns where joints are [n, J, 3] from place and heading, each turned by a share of the way to the other."""
    (root, turns), (other_root, other_turns) = (pose_from_place(one) for one in sides)
    root = root + share[:, None] * (other_root - root)
    turns = quaternion.slerp(turns, other_turns, share[:, None])
    return world_transforms(sides[0].stage.bank.skeleton, root, turns)[0]


def pose_from_place(characters: Characters) -> tuple[Floats, Floats]:
    """Returns roots [n, 3] and local rotations [n, J, 4] of characters, seen from their place and heading."""
    poses, state = characters.stage.evaluator.poses(len(characters)), characters.state
    characters.evaluate(poses)
    back, turns = quaternion.about(UP, -state[:, col.HEADING]), poses.rotations.astype(np.float64)
    turns[:, 0] = quaternion.multiply(back, turns[:, 0])
    return quaternion.rotate(back, poses.root_positions - state[:, col.PLACE : col.PLACE + 3]), turns


def path_step(before: States, now: States) -> tuple[Floats, Floats]:
    """Returns how far characters go [n, 3], from their heading, and turn [n], between two states."""
    back = quaternion.about(UP, -before[:, col.HEADING])
    moved = now[:, col.PLACE : col.PLACE + 3] - before[:, col.PLACE : col.PLACE + 3]
    return quaternion.rotate(back, moved), now[:, col.HEADING] - before[:, col.HEADING]


def smooth(t: Floats) -> Floats:
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))
