"""The slow, readable twin of the kernels by which standing feet drive the root of a character."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from tests.naive import vectors_between

UP = [0.0, 1.0, 0.0]


class Played(NamedTuple):
    """A locomotion at a moment: its share, path [4], feet relative to it [2, 3], and how firmly they stand [2]."""

    share: float
    path: Floats
    feet: Floats
    support: Floats


def played(bank: Bank, s: Floats) -> dict[int, Played]:
    """Returns what the character in a row plays, by number of clip."""
    found = {}
    for number in range(int(s[col.LOCOMOTIONS])):
        slot = s[col.FIRST_LOCOMOTION + number * col.LOCOMOTION_COLUMNS :]
        entry = bank.clips[int(slot[col.CLIP])]
        paths, clip = bank.root_path(entry.name, seam=True), bank.motion(entry.name, seam=True)
        feet = joint_positions(clip)[:, [joints[-1] for joints in bank.roles.feet]] - paths[:, None, :3]
        feet = quaternion.rotate(quaternion.about(UP, -paths[:, 3])[:, None], feet)
        support = bank.tables["feet"][entry.first_row : entry.first_row + entry.row_count, [2, 5]]
        at = slot[col.FRAME]
        found[int(slot[col.CLIP])] = Played(
            slot[col.SHARE], *(vectors_between(rows, at) for rows in (paths, feet, support))
        )
    return found


def root_step(bank: Bank, before: Floats, after: Floats) -> Floats:
    """Returns the root motion [3] in metres, relative to the heading before, between two rows without a loop."""
    old, new = played(bank, before), played(bank, after)
    steps, turns = {}, {}
    for clip, now in new.items():
        steps[clip] = quaternion.rotate(quaternion.about(UP, -old[clip].path[3]), (now.path - old[clip].path)[:3])
        turns[clip] = now.path[3] - old[clip].path[3]
    step = sum(new[clip].share * steps[clip] for clip in new)
    turn = sum(new[clip].share * turns[clip] for clip in new)
    blended = min((1.0 - max(one.share for one in new.values())) / 0.25, 1.0)
    slips, firms = [], []
    for foot in (0, 1):
        own, support = np.zeros(3), 0.0
        for clip, now in new.items():
            weight = now.share * (old[clip].support[foot] + now.support[foot]) / 2.0
            moved = quaternion.rotate(quaternion.about(UP, turns[clip]), now.feet[foot]) - old[clip].feet[foot]
            own, support = own + weight * (steps[clip] + moved), support + weight
        there = sum(one.share * one.feet[foot] for one in old.values())
        here = quaternion.rotate(quaternion.about(UP, turn), sum(one.share * one.feet[foot] for one in new.values()))
        held = np.clip((support - 0.4) / 0.2, 0.0, 1.0)
        firms.append(held**2 * (3.0 - 2.0 * held))
        slips.append(step + here - there - (1.0 - blended * firms[-1] ** 3) * own / max(support, 1e-12))
    squares = np.square(firms)
    if squares.sum() > 0.0:
        step = step - max(firms) * (squares[0] * slips[0] + squares[1] * slips[1]) / squares.sum() * [1.0, 0.0, 1.0]
    return np.asarray(step)
