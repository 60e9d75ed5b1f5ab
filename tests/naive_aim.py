"""The slow, readable twin of the kernels that turn a pose toward targets: turns whole branches of a skeleton."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import local_rotations, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import common_ancestor
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col

UP, FORWARD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
SOFT, NEAR = np.radians(10.0), 0.1
MOST_REST, MOST_SWIVEL = np.radians([90.0, 45.0])


class Body:
    """A pose with the root at the origin, in the frame of the character's heading."""

    def __init__(self, bank: Bank, rotations: Floats) -> None:
        self.skeleton, self.rotations, self.whole = bank.skeleton, rotations.copy(), quaternion.IDENTITY

    def places(self) -> Floats:
        return world_transforms(self.skeleton, [[0.0, 0.0, 0.0]], self.rotations[None])[0][0]

    def world(self) -> Floats:
        return world_transforms(self.skeleton, [[0.0, 0.0, 0.0]], self.rotations[None])[1][0]

    def turn(self, joints: Sequence[int], turn: Floats) -> None:
        """Turns joints of a chain, and all below the last, by equal parts of a turn of the world."""
        world, turned = self.world(), self.world()
        for number, joint in enumerate(joints, 1):
            part = share(turn, number / len(joints))
            for below in self.skeleton.subtree(joint):
                turned[below] = quaternion.multiply(part, world[below])
        self.rotations = local_rotations(self.skeleton, turned)


def aimed(bank: Bank, s: Floats, root: Floats, rotations: Floats) -> Floats:
    """Returns the rotations [J, 4] of a pose, turned toward the targets in the row of a character."""
    skeleton, roles = bank.skeleton, bank.roles
    heading = 0.0 if s[col.IN_PLACE] else s[col.HEADING]
    body = Body(bank, rotations)
    body.rotations[0] = quaternion.multiply(quaternion.about(UP, -heading), body.rotations[0])
    chest = common_ancestor(skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    trunk = skeleton.chain(chest)[::-1][skeleton.chain(chest)[::-1].index(roles.pelvis) :]
    head = roles.head if roles.head >= 0 else roles.neck if roles.neck >= 0 else chest
    neck = [joint for joint in skeleton.chain(head)[::-1] if joint not in skeleton.chain(chest)]
    gaze, eyes, shoulders, rests = neutral(bank, chest, head)
    slots = {part: s[part : part + col.AIM_COLUMNS] for part in (col.CHEST, col.LEFT, col.RIGHT, col.GAZE)}
    shown = {part: slot[col.SHOWN] if slot[col.TARGET] else 0.0 for part, slot in slots.items()}

    lefts: dict[int, Floats] = {}

    def way(part: int, place: Floats) -> Floats:
        slot = slots[part]
        to = vector(s, slot, root, place)
        lefts[part] = slot[[col.YAW_LEFT, col.PITCH_LEFT]]
        if slot[col.CHANGED]:  # it begins where the earlier target was
            lefts[part] = lefts[part] + slot[[col.YAW, col.PITCH]] - limited(slot, to)
        return facing(slot, to, lefts[part])

    def mean_place(joint: int, offset: Floats) -> Floats:
        return np.asarray(body.places()[joint] + quaternion.rotate(body.world()[joint], offset))

    look = aim = turn = quaternion.IDENTITY
    if slots[col.GAZE][col.TARGET]:
        look = way(col.GAZE, mean_place(chest, eyes))
        spine = slots[col.GAZE][col.SPINE] if neck else 1.0
        turn = share(look, shown[col.GAZE] * spine * (1.0 - shown[col.CHEST]))
    if slots[col.CHEST][col.TARGET]:
        aim = share(way(col.CHEST, mean_place(chest, shoulders)), shown[col.CHEST])
        turn = quaternion.multiply(aim, turn)
    body.turn(trunk, turn)
    whole = turn
    if shown[col.CHEST] > 0.0:
        slot, seen = slots[col.CHEST], aim
        if slot[col.TARGET] == col.POINT:
            seen = share(way(col.CHEST, mean_place(chest, shoulders)), shown[col.CHEST])
            more = quaternion.multiply(seen, quaternion.conjugate(aim))
            body.turn([chest], more)
            whole = quaternion.multiply(more, whole)
        to = vector(s, slot, root, np.zeros(3))
        seen = share(facing(slot, to, lefts[col.CHEST]), shown[col.CHEST])
        ahead, at = quaternion.rotate(seen, FORWARD), body.places()[chest]
        hands = body.places()[[roles.left_wrist, roles.right_wrist]] - at
        swivel = swivel_of(hands, at, np.arctan2(ahead[0], ahead[2]))
        more = quaternion.about(UP, shown[col.CHEST] * slot[col.STEADY] * swivel)
        body.turn([chest], more)
        whole = quaternion.multiply(more, whole)
    for part, shoulder, wrist in (
        (col.LEFT, roles.left_shoulder, roles.left_wrist),
        (col.RIGHT, roles.right_shoulder, roles.right_wrist),
    ):
        if slots[part][col.TARGET]:
            places = body.places()
            goal = quaternion.rotate(way(part, places[shoulder]), FORWARD)
            rest = quaternion.rotate(body.world()[chest], rests[part])
            body.turn([shoulder], part_of_swing(rest, places[wrist] - places[shoulder], goal, shown[part]))
    if shown[col.GAZE] > 0.0 and neck:

        def missing(look: Floats) -> Floats:
            way = quaternion.multiply(look, quaternion.conjugate(whole))
            seen = quaternion.rotate(quaternion.multiply(way, before), gaze)
            rest = bounded(quaternion.between(seen, quaternion.rotate(look, FORWARD)), MOST_REST)
            return quaternion.multiply(share(rest, slots[col.GAZE][col.STEADY]), way)

        before = body.world()[head]
        estimated = share(missing(look), shown[col.GAZE] / len(neck))
        for joint in neck[:-1]:
            body.turn([joint], estimated)
        if slots[col.GAZE][col.TARGET] == col.POINT:
            look = way(col.GAZE, body.places()[head])
        wanted = quaternion.multiply(share(missing(look), shown[col.GAZE]), before)
        body.turn([head], quaternion.multiply(wanted, quaternion.conjugate(body.world()[head])))
    body.rotations[0] = rotations[0]
    return body.rotations


def neutral(bank: Bank, chest: int, head: int) -> tuple[Floats, Floats, Floats, dict[int, Floats]]:
    """Where the head looks, in its frame, and head, shoulders, and the rest of each arm, 40 degrees outward and down of
    ahead, in the chest's, as means of the baseline's stride."""
    clip, roles = bank.motion(bank.baseline.clip), bank.roles
    frames = range(round(bank.baseline.start * clip.rate), round(bank.baseline.end * clip.rate))
    gazes, eyes, shoulders = [], [], []
    rests: dict[int, list[Floats]] = {col.LEFT: [], col.RIGHT: []}
    for frame in frames:
        places, world = world_transforms(bank.skeleton, clip.root_positions[[frame]], clip.rotations[[frame]])
        ahead = quaternion.rotate(quaternion.about(UP, bank.root_path(clip.name)[frame, 3]), FORWARD)
        middle = 0.5 * (places[0, roles.left_shoulder] + places[0, roles.right_shoulder])
        gazes.append(quaternion.rotate(quaternion.conjugate(world[0, head]), ahead))
        back = quaternion.conjugate(world[0, chest])
        eyes.append(quaternion.rotate(back, places[0, head] - places[0, chest]))
        shoulders.append(quaternion.rotate(back, middle - places[0, chest]))
        for part, yaw in ((col.LEFT, 40.0), (col.RIGHT, -40.0)):
            down = quaternion.rotate(quaternion.about([1.0, 0.0, 0.0], np.radians(40.0)), FORWARD)
            aside = quaternion.about(UP, bank.root_path(clip.name)[frame, 3] + np.radians(yaw))
            rests[part].append(quaternion.rotate(back, quaternion.rotate(aside, down)))
    means = {part: quaternion.unit(np.mean(drawn, axis=0)) for part, drawn in rests.items()}
    return quaternion.unit(np.mean(gazes, axis=0)), np.mean(eyes, axis=0), np.mean(shoulders, axis=0), means


def vector(s: Floats, slot: Floats, root: Floats, place: Floats) -> Floats:
    """Returns the vector to a target, in the frame of the heading; `place` is relative to the root."""
    turn, to = quaternion.about(UP, -s[col.HEADING]), slot[col.TO : col.TO + 3]
    if slot[col.TARGET] == col.DIRECTION:
        return quaternion.rotate(turn, to)
    if s[col.IN_PLACE]:
        return np.asarray(quaternion.rotate(turn, to - s[col.PLACE : col.PLACE + 3]) - root - place)
    return np.asarray(quaternion.rotate(turn, to - root) - place)


def limited(slot: Floats, to: Floats) -> Floats:
    """Returns yaw and pitch [2] to a target within the limits."""
    level, length = float(np.hypot(to[0], to[2])), float(np.linalg.norm(to))
    yaw, pitch = np.arctan2(to[0], to[2]), np.arctan2(to[1], level)
    near = step(length / NEAR) if slot[col.TARGET] == col.POINT else 1.0
    back = np.pi - max(slot[col.MOST_YAW], np.pi / 2.0)
    flat = np.cos(max(slot[col.MOST_PITCH], np.pi / 4.0))  # nearer to the vertical the yaw counts less
    yaw_share = near * step((np.pi - abs(yaw)) / back) * step(level / (flat * length) if length else 0.0)
    return np.array(
        [
            np.sign(yaw) * yaw_share * soft(abs(yaw), slot[col.MOST_YAW]),
            np.sign(pitch) * near * soft(abs(pitch), slot[col.MOST_PITCH]),
        ]
    )


def facing(slot: Floats, to: Floats, left: Floats) -> Floats:
    yaw, pitch = limited(slot, to) + left
    return quaternion.multiply(quaternion.about(UP, yaw), quaternion.about([1.0, 0.0, 0.0], -pitch))


def soft(angle: float, most: float) -> float:
    """Follows an angle up to SOFT below `most`, then a parabola that ends level at `most`."""
    bend = min(SOFT, most / 2.0)
    if angle <= most - bend:
        return angle
    over = min((angle - most + bend) / bend, 2.0) if bend else 2.0
    return most - bend * (1.0 - over / 2.0) ** 2


def step(t: float) -> float:
    t = float(np.clip(t, 0.0, 1.0))
    return 3.0 * t**2 - 2.0 * t**3


def share(turn: Floats, part: float) -> Floats:
    vector = part * quaternion.log(turn)
    angle = float(np.linalg.norm(vector))
    return quaternion.about(vector / angle, angle) if angle > 1e-12 else quaternion.IDENTITY


def part_of_swing(rest: Floats, line: Floats, goal: Floats, part: float) -> Floats:
    """A part of the turn from `line` back to `rest` and on to `goal`, each by the shortest way, along its one axis."""
    turn = quaternion.multiply(quaternion.between(rest, goal), quaternion.conjugate(quaternion.between(rest, line)))
    sine = float(np.linalg.norm(turn[:3]))
    angle = 2.0 * np.arctan2(sine, turn[3])  # up to 360 degrees
    return quaternion.about(turn[:3] / sine, part * angle) if sine > 1e-12 else quaternion.IDENTITY


def bounded(turn: Floats, most: float) -> Floats:
    angle = float(quaternion.angle(turn, quaternion.IDENTITY))
    if angle <= most - SOFT:
        return turn
    return share(turn, soft(angle, most) * step((np.pi - angle) / (np.pi - most)) / angle)


def swivel_of(hands: Floats, chest: Floats, yaw: float) -> float:
    """Returns the turn of the chest about the vertical after which hands [2, 3] are at a yaw, seen from the root."""
    far, (x, _, z) = np.linalg.norm(hands, axis=1).mean(), hands.mean(axis=0)
    reach = float(np.hypot(x, z))
    aside = (chest[0] * np.cos(yaw) - chest[2] * np.sin(yaw)) / max(reach, 0.5 * far)
    swivel = yaw - np.arcsin(np.clip(aside, -1.0, 1.0)) - np.arctan2(x, z)
    swivel = (swivel + np.pi) % (2.0 * np.pi) - np.pi
    size = soft(abs(swivel), MOST_SWIVEL) * step((np.pi - abs(swivel)) / (np.pi - MOST_SWIVEL))
    return float(np.sign(swivel) * size * step((reach / far - 0.5) / (0.8 - 0.5)))
