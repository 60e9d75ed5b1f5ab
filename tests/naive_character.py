"""The slow, readable twin of the kernels that pose characters, from the bank's clips in their editable form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import common_ancestor
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action_kernels import CATCH_UP, MOST_PACE
from motionsplice.runtime.requests import METHODS, POSTURES
from tests.naive import best_rotation, laid_on, rotation_between, vectors_between
from tests.playing import evaluated

UP = [0.0, 1.0, 0.0]


class Locomotion(NamedTuple):
    """A locomotion slot: its share, its root relative to its path, its rotations and its torso."""

    share: float
    root: Floats
    rotations: Floats
    cloud: Floats
    frame: Floats
    offset: Floats
    posture: Floats


def check(characters: Characters) -> None:
    """Checks that the kernels pose each character as `pose` does."""
    before = characters.state.copy()
    roots, rotations = evaluated(characters)
    for row, state in enumerate(before):
        root, twin = pose(characters.stage.bank, state)
        np.testing.assert_allclose(roots[row], root, atol=1e-4)
        assert quaternion.angle(rotations[row], twin).max() < 1e-3


def mixed(rotations: Sequence[Floats], shares: Sequence[float]) -> Floats:
    """Mixes rotations [..., 4] by their shares, each added along the shorter arc."""
    total = np.zeros_like(rotations[0])
    for rotation, share in zip(rotations, shares, strict=True):
        near = np.sum(total * rotation, axis=-1, keepdims=True)
        total = total + share * np.where(near >= 0.0, rotation, -rotation)
    return np.asarray(total / np.linalg.norm(total, axis=-1, keepdims=True))


def pose(bank: Bank, s: Floats) -> tuple[Floats, Floats]:
    """Root position [3] and local rotations [J, 4] of the character in a row."""
    pelvis, upper = bank.roles.pelvis, bank.skeleton.subtree(bank.roles.pelvis)
    slots = [s[col.FIRST_LOCOMOTION + k * col.LOCOMOTION_COLUMNS :] for k in range(int(s[col.LOCOMOTIONS]))]
    legs = [locomotion(bank, s, slot, 1.0 if len(slots) == 1 else slot[col.SHARE]) for slot in slots]
    shares = [one.share for one in legs]

    def mean(values: Sequence[Floats]) -> Floats:
        return np.asarray(sum(share * value for share, value in zip(shares, values, strict=True)))

    rotations = mixed([one.rotations for one in legs], shares)
    root, cloud = mean([one.root for one in legs]), mean([one.cloud for one in legs])
    frame, offset = mixed([one.frame for one in legs], shares), mixed([one.offset for one in legs], shares)
    posture, own_pelvis = mean([one.posture for one in legs]), rotations[pelvis].copy()
    layers = [s[col.FIRST_ACTION + k * col.ACTION_COLUMNS :] for k in range(int(s[col.ACTIONS]))]
    weights = parts_of_layers(layers)
    sources, pelves = [rotations.copy()], [own_pelvis]
    for layer in layers:
        if layer[col.KIND] == col.OWN:
            sources.append(rotations)
            pelves.append(own_pelvis)
            continue
        name, at = bank.numbered[int(layer[col.CLIP])].name, layer[col.FRAME]
        if layer[col.KIND] == METHODS["naive"]:
            last = bank.clip(name).frame_count - 1.0
            at = at if at <= last else at % last
        sampled = bank.motion(name, seam=True).sampled([at])[1][0]
        wear(bank, s, name, at, sampled)
        sources.append(sampled)
        if layer[col.KIND] == METHODS["naive"]:
            pelves.append(sampled[pelvis])
            continue
        if is_added(bank, layer):
            sources[-1] = laid_on(bank, sources[0], frame, name, at, sampled)
            pelves.append(sources[-1][pelvis])
            continue
        torso = bank.torso(name, seam=True)
        turned = quaternion.multiply(own_pelvis, best_rotation(cloud, vectors_between(torso.clouds, at)))
        turn = quaternion.IDENTITY
        if layer[col.POSTURE] == POSTURES["relative"]:
            turn = quaternion.multiply(rotation_between(torso.offsets, at), quaternion.conjugate(offset))
        elif layer[col.POSTURE] == POSTURES["absolute"]:
            turn = best_rotation(bank.posture(name), posture)
        world_turn = quaternion.multiply(quaternion.multiply(frame, turn), quaternion.conjugate(frame))
        pelves.append(quaternion.multiply(world_turn, turned))
    chains = limbs(bank)
    for joint in upper:
        part = next((part for part, chain in chains.items() if joint in bank.skeleton.subtree(chain[-1])), 0)
        if joint == pelvis:
            rotations[joint] = mixed(pelves, [weight[0] for weight in weights])
        else:
            given = [weight[part] for weight in weights]
            if part and joint == chains[part][-1]:
                for number, layer in enumerate(layers, 1):
                    given[number] *= not is_apart(bank, layer)
            if sum(given) > 1e-9:
                rotations[joint] = mixed([source[joint] for source in sources], given)
    for part, chain in chains.items():
        rest = 1.0 - sum(w[part] for w, layer in zip(weights[1:], layers, strict=True) if is_apart(bank, layer))
        for number, layer in enumerate(layers, 1):
            if is_apart(bank, layer) and weights[number][part] > 0.0:
                wanted = quaternion.multiply(pelves[number], chained(sources[number], chain))
                trunk = quaternion.multiply(rotations[pelvis], chained(rotations, chain[:-1]))
                local = quaternion.multiply(quaternion.conjugate(trunk), wanted)
                share = weights[number][part]
                rotations[chain[-1]] = mixed([local, rotations[chain[-1]]], [share, max(rest, 0.0)])
                rest += share
    if not s[col.IN_PLACE]:
        turn = quaternion.about(UP, s[col.HEADING])
        root = quaternion.rotate(turn, root) + s[col.PLACE : col.PLACE + 3] - origin(s)
        rotations[0] = quaternion.multiply(turn, rotations[0])
    return root, rotations


def origin(s: Floats) -> Floats:
    """Returns what a pose is relative to [3], metres: the nearest multiples of 256, or 0."""
    return s[col.REBASED] * 256.0 * np.floor(s[col.PLACE : col.PLACE + 3] / 256.0 + 0.5)


def action_step(bank: Bank, s: Floats, locomotion_step: float, phase: float, seconds: float) -> float:
    """Returns the cycles that an action advances in step with one gait, by the action's slot `s` before the step.

    locomotion_step: the cycles that the gait advances. phase: the gait's after that. seconds: of playback.
    """
    name = bank.numbered[int(s[col.CLIP])].name
    clip, phases = bank.clip(name), bank.phase(name, seam=True)
    ahead = locomotion_step - (phase - s[col.PHASE])
    ahead -= round(ahead)
    most = CATCH_UP * locomotion_step
    step = locomotion_step - float(np.clip(ahead, -most, most))
    if s[col.OWN_TO] == col.ANY_PACE:
        return step
    last, frame = clip.row_count - 1.0, s[col.FRAME] + MOST_PACE * seconds * clip.rate
    reached = np.interp(min(frame, last), np.arange(clip.row_count), phases)
    if frame > last:  # as after the jump back by whole strides
        back = np.interp(clip.last_phase - clip.loop, phases, np.arange(clip.row_count))
        again = np.interp([back, back + frame - last], np.arange(clip.row_count), phases)
        reached += again[1] - again[0]
    return min(step, float(reached - s[col.PHASE]))


def wear(bank: Bank, s: Floats, body: str, frame: float, rotations: Floats) -> None:
    """Lays the hands that a character wears over the rotations [J, 4] of a body.

    Each slot is mixed with the body's own hands by its weight, and faded in over the slots below it. Hands that are not
    aligned to the body stand for the body's own.
    """
    joints, worn = list(bank.layout.hands.joints), list[Floats]()
    shares = [1.0]
    for number in range(int(s[col.HANDS])):
        slot = s[col.FIRST_HANDS + number * col.HANDS_COLUMNS :]
        name = bank.hand_clips[int(slot[col.CLIP])] if slot[col.CLIP] != col.BARE else ""
        aligned = any((one.name, one.body) == (name, body) for one in bank.hands)
        worn.append(rotation_between(bank.hand_motion(name, body), frame) if aligned else rotations[joints])
        faded, given = fade(slot), float(slot[col.WEIGHT]) if aligned else 0.0
        shares = [(1.0 - faded) * share for share in shares] + [faded * given]
        shares[0] += faded * (1.0 - given)
    below = shares[0]
    for turns, share in zip(worn, shares[1:], strict=True):
        below += share
        if share > 0.0:
            rotations[joints] = mixed([rotations[joints], turns], [below - share, share])


def locomotion(bank: Bank, s: Floats, slot: Floats, share: float) -> Locomotion:
    name, at = bank.numbered[int(slot[col.CLIP])].name, slot[col.FRAME]
    roots, rotations = bank.motion(name, seam=True).sampled([at])
    wear(bank, s, name, at, rotations[0])
    x, y, z, heading = vectors_between(bank.root_path(name, seam=True), at)
    torso, turn = bank.torso(name, seam=True), quaternion.about(UP, -heading)
    rotations[0, 0] = quaternion.multiply(turn, rotations[0, 0])
    return Locomotion(
        share,
        quaternion.rotate(turn, roots[0] - [x, y, z]),
        rotations[0],
        vectors_between(torso.clouds, at),
        rotation_between(torso.frames, at),
        rotation_between(torso.offsets, at),
        bank.posture(name),
    )


def parts_of_layers(layers: Sequence[Floats]) -> list[list[float]]:
    """Returns the share of each part: of the locomotions' own upper body, then of each action."""
    weights = [[1.0] * col.PARTS]
    for layer in layers:
        faded = fade(layer)
        given = 0.0 if layer[col.KIND] == col.OWN else layer[col.WEIGHT]
        covers = [faded if int(layer[col.MASK]) >> part & 1 else 0.0 for part in range(col.PARTS)]
        weights = [[w * (1.0 - c) for w, c in zip(one, covers, strict=True)] for one in weights]
        weights[0] = [w + c * (1.0 - given) for w, c in zip(weights[0], covers, strict=True)]
        weights.append([c * given for c in covers])
    return weights


def fade(slot: Floats) -> float:
    t = 1.0 if slot[col.ELAPSED] >= slot[col.LASTING] else slot[col.ELAPSED] / slot[col.LASTING]
    forms = {
        col.LINEAR: t,
        col.SMOOTH: t * t * (3.0 - 2.0 * t),
        col.EASE_IN: t * t,
        col.EASE_OUT: 1.0 - (1.0 - t) ** 2,
    }
    return float(forms[int(slot[col.CURVE])])


def is_apart(bank: Bank, layer: Floats) -> bool:
    spliced = layer[col.KIND] == METHODS["splice"] and not is_added(bank, layer)
    return bool(spliced and not int(layer[col.MASK]) & col.TRUNK)


def is_added(bank: Bank, layer: Floats) -> bool:
    stands = bank.numbered[int(layer[col.CLIP])].stands
    return bool(layer[col.KIND] == METHODS["splice"] and layer[col.POSTURE] == POSTURES["relative"] and stands)


def limbs(bank: Bank) -> dict[int, list[int]]:
    """Returns, by number of part, the joints from the pelvis's child to the first joint of a limb."""
    skeleton, roles = bank.skeleton, bank.roles
    chest = common_ancestor(skeleton.parents, [roles.left_shoulder, roles.right_shoulder])
    found = {}
    for part, tip in ((1, roles.left_shoulder), (2, roles.right_shoulder), (3, roles.neck)):
        chain = skeleton.chain(tip)[::-1]
        found[part] = [int(one) for one in chain[chain.index(roles.pelvis) + 1 : chain.index(chest) + 2]]
    return found


def chained(rotations: Floats, chain: Sequence[int]) -> Floats:
    """Returns the product of the rotations along a chain of joints."""
    turn = np.asarray(quaternion.IDENTITY)
    for joint in chain:
        turn = quaternion.multiply(turn, rotations[joint])
    return turn
