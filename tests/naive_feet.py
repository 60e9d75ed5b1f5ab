"""The slow, readable twin of the kernels by which standing feet drive the root of a character and are locked."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import joint_positions, local_rotations, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.mirrored import MIRRORED
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
        entry = bank.numbered[int(slot[col.CLIP])]
        paths, clip = bank.root_path(entry.name, seam=True), bank.motion(entry.name, seam=True)
        feet = joint_positions(clip)[:, [joints[-1] for joints in bank.roles.feet]] - paths[:, None, :3]
        feet = quaternion.rotate(quaternion.about(UP, -paths[:, 3])[:, None], feet)
        sides = [5, 2] if entry.name.endswith(MIRRORED) else [2, 5]
        support = bank.tables["feet"][entry.first_row : entry.first_row + entry.row_count, sides]
        at = slot[col.FRAME]
        found[int(slot[col.CLIP])] = Played(
            slot[col.SHARE], *(vectors_between(rows, at) for rows in (paths, feet, support))
        )
    return found


def root_step(bank: Bank, before: Floats, after: Floats, seconds: float) -> Floats:
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
        against = -max(firms) * (squares[0] * slips[0] + squares[1] * slips[1]) / squares.sum() * [1.0, 0.0, 1.0]
        step = step + against / (1.0 + (np.linalg.norm(against) / (2.4 * seconds)) ** 8) ** 0.125
    return np.asarray(step)


def smooth(t: float) -> float:
    t = float(np.clip(t, 0.0, 1.0))
    return t * t * (3.0 - 2.0 * t)


def hold(before: Floats, moved: Floats, turn: float, support: float, seconds: float, reach: float) -> Floats:
    """Returns the hold [3] of a foot after a frame: its offset x and z from the pose, and for how long it has stood.

    before: [3] the same before. moved: [2] how far the foot went over the ground, metres. Both are relative to the
    character's heading before, which then turns by `turn`.
    """
    firm, offset = smooth((support - 0.4) / 0.2), before[:2]
    held = firm * (1.0 - smooth(2.0 * np.hypot(*offset) / reach - 1.0))
    held *= 1.0 - smooth((np.hypot(*moved) / seconds - 0.75) / 0.75)
    stood = before[2] + seconds if firm > 0.0 else 0.0
    fading = (1.0 - held) / 0.12 + smooth(stood - 1.0) / 0.5
    x, z = (offset - held * moved) * np.exp(-fading * seconds)
    return np.array([np.cos(turn) * x - np.sin(turn) * z, np.sin(turn) * x + np.cos(turn) * z, stood])


def bent(bank: Bank, root: Floats, rotations: Floats, offsets: Floats) -> Floats:
    """Returns rotations [J, 4] of a pose whose ankles are moved over the ground by `offsets` [2, 2], metres."""
    roles, skeleton = bank.roles, bank.skeleton
    for side, (x, z) in zip(("left", "right"), offsets, strict=True):
        hip, knee, ankle = (getattr(roles, f"{side}_{joint}") for joint in ("hip", "knee", "ankle"))
        positions, world = (one[0] for one in world_transforms(skeleton, root[None], rotations[None]))
        thigh, shin, leg = (positions[a] - positions[b] for a, b in ((hip, knee), (ankle, knee), (ankle, hip)))
        a, b, before = (np.linalg.norm(one) for one in (thigh, shin, leg))
        axis = np.cross(thigh, shin)
        sine = np.linalg.norm(axis) / (a * b)
        wanted = leg + np.array([x, 0.0, z])
        change = (np.linalg.norm(wanted) - before) * sine**2 / (sine**2 + 0.25)
        room = 0.998 * (a + b) - before
        if change > 0.0:
            change *= (1.0 - np.exp(-change / room)) * room / change if room > 0.0 else 0.0
        angles = [np.arccos((a**2 + b**2 - length**2) / (2.0 * a * b)) for length in (before + change, before)]
        bend = quaternion.about(quaternion.unit(axis), angles[0] - angles[1])
        swing = quaternion.between(quaternion.rotate(bend, shin) - thigh, wanted)
        turned = world.copy()
        turned[skeleton.subtree(knee)] = quaternion.multiply(bend, turned[skeleton.subtree(knee)])
        turned[skeleton.subtree(hip)] = quaternion.multiply(swing, turned[skeleton.subtree(hip)])
        turned[skeleton.subtree(ankle)] = world[skeleton.subtree(ankle)]
        rotations = local_rotations(skeleton, turned)
    return rotations
