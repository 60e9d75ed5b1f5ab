"""How far standing feet slide over the ground.

A foot stands while the locomotions in which it has contact hold at least half of the shares. It rolls from heel to toe,
so in each frame the joint that moves least is taken as the one that stands. The slide of a stance is the extent of the
way that this joint goes over the ground.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from bench.characters.joint_speeds import character_positions
from bench.characters.steady import LEGS
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.format.contacts import FEET, which_stand
from motionsplice.runtime.simd.handle import handle_of
from motionsplice.runtime.stage import Stage

BRIEF = 6  # frames: stances of at most so many do not count


class Stance(NamedTuple):
    """A stance: number of the character, its first frame and the frame after its last, and its slide in metres."""

    character: int
    first: int
    end: int
    slide: float


def without_feet(stage: Stage) -> Stage:
    """Returns a stage whose feet never stand, so that none drives a root."""
    bare = Stage(stage.evaluator)
    ground = stage.arrays.ground
    bare.arrays = stage.arrays._replace(ground=ground._replace(feet=np.zeros_like(ground.feet)))
    bare._handle = handle_of(bare.arrays)
    return bare


def stances(characters: Characters, frames: int, before: Callable[[int], None] = lambda _: None) -> Iterator[Stance]:
    """Plays `frames` frames, and yields all stances that begin and end in them.

    Calls `before` with the number of each frame before it is evaluated.
    """
    positions, standing = [], []
    for frame in range(frames):
        before(frame)
        positions.append(character_positions(characters))
        standing.append(standing_feet(characters))
        characters.advance()
    yield from stances_of(characters.stage, np.array(positions), np.array(standing))


def stances_of(stage: Stage, positions: Floats, standing: Floats) -> Iterator[Stance]:
    """Yields all stances that begin and end in F frames.

    Args:
        stage: Knows the joints of the feet.
        positions: [F, n, J, 3], of the joints of n characters.
        standing: [F, n, 2], the shares of the locomotions in which the left and the right foot stand.
    """
    moves = np.diff(positions[:, :, np.array(stage.bank.roles.feet)][..., [0, 2]], axis=0)  # [F - 1, n, 2, joints, 2]
    least = np.linalg.norm(moves, axis=-1).argmin(axis=-1)
    steps = np.take_along_axis(moves, least[..., None, None], axis=3)[:, :, :, 0]
    stands = (standing >= 0.5).astype(np.int8)
    for foot in range(len(FEET)):
        for character in range(stands.shape[1]):
            edges = np.flatnonzero(np.diff(stands[:, character, foot])) + 1
            if stands[0, character, foot]:
                edges = edges[1:]  # it began before the first frame
            for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=False):
                if end - first > BRIEF:
                    way = np.cumsum(steps[first : end - 1, character, foot], axis=0)
                    extent = np.maximum(way.max(axis=0), 0.0) - np.minimum(way.min(axis=0), 0.0)
                    yield Stance(character, first, end, float(np.linalg.norm(extent)))


def standing_feet(characters: Characters) -> Floats:
    """Returns the shares [n, 2] of the locomotions in which the left and the right foot stand."""
    state, bank = characters.state, characters.stage.bank
    first_rows = np.array([clip.first_row for clip in bank.clips])
    found = np.zeros((len(state), len(FEET)))
    for number, slot in enumerate(LEGS):
        used = number < state[:, col.LOCOMOTIONS]
        row = first_rows[state[:, slot + col.CLIP].astype(np.int64)] + state[:, slot + col.FRAME].astype(np.int64)
        bits = bank.tables["contacts"][np.where(used, row, 0)]
        share = np.where(used, state[:, slot + col.SHARE], 0.0)
        found += share[:, None] * which_stand(bits)
    return found
