"""Turns trunk, arms, neck and head of a pose toward their targets.

All happens in the frame of the character's heading, with the root at the origin, in float64. The trunk's turn follows
from heading and target, not from the pose, so the bob and the sway of the gait stay in it. It is shared by turning each
joint, in the world, by the same part. The chest, a shoulder or the head then makes up for what is still missing.
"""

from __future__ import annotations

import math

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.aim_kernels import SOFT, soft, way_to
from motionsplice.runtime.characters.chains import LEFT_ARM, NECK, RIGHT_ARM, TRUNK, Chains
from motionsplice.runtime.characters.slots import origin_of
from motionsplice.runtime.characters.transition_kernels import in_turned_frame
from motionsplice.runtime.kernels.curves import smooth
from motionsplice.runtime.kernels.rotations import TINY
from motionsplice.runtime.kernels.turns import (
    Turn,
    Vector,
    about_y,
    between,
    forward_of,
    inverse,
    length,
    middle,
    minus,
    part_of,
    plus,
    straight_part_of,
    times,
    turn_at,
    turn_joint,
    turned,
    unit_vector,
)
from motionsplice.runtime.simd.compiled import Array, inlined, kernel

MOST_REST = math.radians(90.0)  # of what a head turns beyond the way from its heading to its target
MOST_SWIVEL = math.radians(45.0)  # of the hands about the vertical
# the middle of both hands is this far beside the chest, divided by how far they are from it, where their swivel begins
# to count, and where it counts fully
HANGING, HELD = 0.5, 0.8


@kernel
def turn_to_targets(chains: Chains, s: Array, c: int, character: int, roots: Array, rotations: Array) -> None:
    """Turns a character's pose toward its targets, in the order of its joints."""
    pose_trunk(chains, s, c, character, rotations)
    look = turn_trunk(chains, s, c, character, roots, rotations)
    if s[c + col.LEFT + col.TARGET] != col.NOTHING:
        turn_arm(chains, LEFT_ARM, s, c, c + col.LEFT, character, roots, rotations)
    if s[c + col.RIGHT + col.TARGET] != col.NOTHING:
        turn_arm(chains, RIGHT_ARM, s, c, c + col.RIGHT, character, roots, rotations)
    if s[c + col.GAZE + col.TARGET] != col.NOTHING and s[c + col.GAZE + col.SHOWN] > 0.0 and chains.lengths[NECK] > 0:
        turn_head(chains, s, c, look, character, roots, rotations)


@inlined
def vector_to(s: Array, c: int, slot: int, character: int, roots: Array, place: Vector) -> Vector:
    """Returns the vector from a place, relative to the root, to a slot's target."""
    x, y, z = s[slot + col.TO], s[slot + col.TO + 1], s[slot + col.TO + 2]
    sin, cos = s[c + col.SIN], s[c + col.COS]
    if s[slot + col.TARGET] == col.DIRECTION:
        x, z = in_turned_frame(sin, cos, x, z)
        return x, y, z
    root = roots[character, 0], roots[character, 1], roots[character, 2]
    if s[c + col.IN_PLACE] != 0.0:
        x, z = in_turned_frame(sin, cos, x - s[c + col.PLACE], z - s[c + col.PLACE + 2])
        y -= s[c + col.PLACE + 1]
        x, z = x - root[0], z - root[2]
    else:
        x, y, z = x - origin_of(s, c, 0), y - origin_of(s, c, 1), z - origin_of(s, c, 2)
        x, z = in_turned_frame(sin, cos, x - root[0], z - root[2])
    return x - place[0], y - root[1] - place[1], z - place[2]


@inlined
def way_from(s: Array, c: int, slot: int, character: int, roots: Array, place: Vector, is_final: bool) -> Turn:
    """Returns the turn of Z that is shown of a slot's target, from a place; `is_final` as in `way_to`."""
    x, y, z = vector_to(s, c, slot, character, roots, place)
    return way_to(s, slot, x, y, z, is_final)


@inlined
def rotation_of(world: Array, joint: int) -> Turn:
    return world[joint, 0], world[joint, 1], world[joint, 2], world[joint, 3]


@inlined
def place_of(world: Array, joint: int) -> Vector:
    return world[joint, 4], world[joint, 5], world[joint, 6]


@inlined
def whole_of(world: Array, joint: int) -> Turn:
    return world[joint, 7], world[joint, 8], world[joint, 9], world[joint, 10]


@inlined
def keep(world: Array, joint: int, rotation: Turn, place: Vector, whole: Turn) -> None:
    """Writes a joint's row of `world`."""
    for i in range(4):
        world[joint, i], world[joint, 7 + i] = rotation[i], whole[i]
    for i in range(3):
        world[joint, 4 + i] = place[i]


@inlined
def offset_of(chains: Chains, chain: int, joint: int) -> Vector:
    return chains.offsets[chain, joint, 0], chains.offsets[chain, joint, 1], chains.offsets[chain, joint, 2]


@inlined
def pose_trunk(chains: Chains, s: Array, c: int, character: int, rotations: Array) -> None:
    """Writes the trunk as it is into `world`."""
    place, whole = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    rotation = turn_at(rotations, character, chains.columns[TRUNK, 0])
    if s[c + col.IN_PLACE] == 0.0:
        rotation = times((0.0, -s[c + col.SIN], 0.0, s[c + col.COS]), rotation)
    keep(chains.world, 0, rotation, place, whole)
    for joint in range(1, chains.lengths[TRUNK]):
        place = plus(place, turned(rotation, offset_of(chains, TRUNK, joint)))
        rotation = times(rotation, turn_at(rotations, character, chains.columns[TRUNK, joint]))
        keep(chains.world, joint, rotation, place, whole)


@inlined
def turn_trunk(chains: Chains, s: Array, c: int, character: int, roots: Array, rotations: Array) -> Turn:
    """Turns the trunk for the gaze, by its share, and for the chest, wholly; returns the way to the gaze's target."""
    world, branch, last = chains.world, chains.firsts[NECK], chains.lengths[TRUNK] - 1
    gaze, chest, turn = c + col.GAZE, c + col.CHEST, (0.0, 0.0, 0.0, 1.0)
    look = aim = turn
    is_aimed = s[chest + col.TARGET] != col.NOTHING
    if s[gaze + col.TARGET] != col.NOTHING:
        eyes = turned(rotation_of(world, branch), (chains.eyes[0], chains.eyes[1], chains.eyes[2]))
        is_final = s[gaze + col.TARGET] == col.DIRECTION or s[gaze + col.SHOWN] == 0.0 or chains.lengths[NECK] == 0
        look = way_from(s, c, gaze, character, roots, plus(place_of(world, branch), eyes), is_final)
        spine = s[gaze + col.SPINE] if chains.lengths[NECK] > 0 else 1.0
        rest = 1.0 - s[chest + col.SHOWN] if is_aimed else 1.0
        turn = part_of(look, s[gaze + col.SHOWN] * spine * rest)
    if is_aimed:
        shoulders = plus(place_of(world, last), turned(rotation_of(world, last), shoulders_of(chains)))
        is_final = s[chest + col.TARGET] == col.DIRECTION or s[chest + col.SHOWN] == 0.0
        aim = part_of(way_from(s, c, chest, character, roots, shoulders, is_final), s[chest + col.SHOWN])
        turn = times(aim, turn)
    if turn[0] != 0.0 or turn[1] != 0.0 or turn[2] != 0.0:
        share_turn(chains, turn, character, rotations)
    if is_aimed and s[chest + col.SHOWN] > 0.0:
        correct_chest(chains, s, c, aim, character, roots, rotations)
    return look


@inlined
def shoulders_of(chains: Chains) -> Vector:
    return chains.shoulders[0], chains.shoulders[1], chains.shoulders[2]


@inlined
def share_turn(chains: Chains, turn: Turn, character: int, rotations: Array) -> None:
    """Turns the trunk's joints by equal parts of a turn, in the pose and in `world`."""
    world, first, count = chains.world, chains.firsts[TRUNK], chains.lengths[TRUNK]
    part, above = part_of(turn, 1.0 / (count - first)), rotation_of(world, first - 1)
    rotation, place = above, place_of(world, first - 1)
    for joint in range(first, count):
        place = plus(place, turned(rotation, offset_of(chains, TRUNK, joint)))
        local = turn_joint(rotations, character, chains.columns[TRUNK, joint], part, above)
        rotation, above = times(rotation, local), rotation_of(world, joint)
        keep(world, joint, rotation, place, times(rotation, inverse(above)))


@kernel
def correct_chest(chains: Chains, s: Array, c: int, aim: Turn, character: int, roots: Array, rotations: Array) -> None:
    """Turns the chest once more: toward a point from where the shoulders now are, and against the hands' swivel."""
    world, last, slot = chains.world, chains.lengths[TRUNK] - 1, c + col.CHEST
    rotation, place, more = rotation_of(world, last), place_of(world, last), (0.0, 0.0, 0.0, 1.0)
    if s[slot + col.TARGET] == col.POINT:
        shoulders = plus(place, turned(rotation, shoulders_of(chains)))
        now = part_of(way_from(s, c, slot, character, roots, shoulders, True), s[slot + col.SHOWN])
        more = times(now, inverse(aim))
    elif s[slot + col.STEADY] == 0.0:
        return
    if s[slot + col.STEADY] > 0.0:
        left = arm_places(chains, LEFT_ARM, times(more, rotation), character, rotations)
        right = arm_places(chains, RIGHT_ARM, times(more, rotation), character, rotations)
        seen = part_of(way_from(s, c, slot, character, roots, (0.0, 0.0, 0.0), False), s[slot + col.SHOWN])
        swivel = swivel_of(left[1], right[1], place, forward_of(seen))
        more = times(about_y(s[slot + col.SHOWN] * s[slot + col.STEADY] * swivel), more)
    turn_joint(rotations, character, chains.columns[TRUNK, last], more, rotation_of(world, last - 1))
    keep(world, last, times(more, rotation), place, times(more, whole_of(world, last)))


@inlined
def swivel_of(left: Vector, right: Vector, chest: Vector, ahead: Vector) -> float:
    """Returns by how much a chest must turn about the vertical until hands, seen from the root, are toward `ahead`.

    `left` and `right` are the hands relative to the chest, `chest` is its place relative to the root. Hands that hang,
    and hands on opposite sides of the chest, have their middle near its vertical, where a small movement would turn
    the way to it around: their swivel does not count.
    """
    yaw, hands = math.atan2(ahead[0], ahead[2]), middle(left, right)
    reach, far = math.hypot(hands[0], hands[2]), 0.5 * (length(left) + length(right)) + TINY
    aside = (chest[0] * math.cos(yaw) - chest[2] * math.sin(yaw)) / max(reach, far * HANGING)
    swivel = yaw - math.asin(min(max(aside, -1.0), 1.0)) - math.atan2(hands[0], hands[2])
    swivel -= 2.0 * math.pi * round(swivel / (2.0 * math.pi))
    size = soft(abs(swivel), MOST_SWIVEL) * smooth((math.pi - abs(swivel)) / (math.pi - MOST_SWIVEL))
    return math.copysign(size * smooth((reach / far - HANGING) / (HELD - HANGING)), swivel)


@inlined
def arm_places(chains: Chains, arm: int, chest: Turn, character: int, rotations: Array) -> tuple[Vector, Vector]:
    """Returns the places of shoulder and wrist relative to the chest."""
    rotation, place, shoulder = chest, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for joint in range(chains.lengths[arm]):
        place = plus(place, turned(rotation, offset_of(chains, arm, joint)))
        rotation = times(rotation, turn_at(rotations, character, chains.columns[arm, joint]))
        if joint == chains.firsts[arm]:
            shoulder = place
    return shoulder, place


@kernel
def turn_arm(
    chains: Chains, arm: int, s: Array, c: int, slot: int, character: int, roots: Array, rotations: Array
) -> None:
    """Turns an arm about its shoulder until the line from shoulder to wrist points to the target."""
    last, column = chains.lengths[TRUNK] - 1, chains.columns[arm, chains.firsts[arm]]
    chest, base = rotation_of(chains.world, last), place_of(chains.world, last)
    shoulder, wrist = arm_places(chains, arm, chest, character, rotations)
    way = way_from(s, c, slot, character, roots, plus(base, shoulder), True)
    if s[slot + col.SHOWN] > 0.0:
        rest = turned(chest, (chains.rests[arm, 0], chains.rests[arm, 1], chains.rests[arm, 2]))
        shown = part_of_swing(rest, unit_vector(minus(wrist, shoulder)), forward_of(way), s[slot + col.SHOWN])
        for joint in range(chains.firsts[arm]):
            chest = times(chest, turn_at(rotations, character, chains.columns[arm, joint]))
        turn_joint(rotations, character, column, shown, chest)


@inlined
def part_of_swing(rest: Vector, line: Vector, goal: Vector, share: float) -> Turn:
    """Returns a share of the turn of an arm from `line` to `goal`, by way of `rest`, where an arm is free to move.

    It takes the shortest turn from `line` to `rest` back, and then that from `rest` to `goal` (Listing's law). So it is
    smooth wherever both are not opposite to `rest`. The shortest turn from `line` to `goal` is not where these are
    opposite: there a small movement of an arm would swing it around.
    """
    return straight_part_of(times(between(rest, goal), inverse(between(rest, line))), share)


@inlined
def bounded(turn: Turn, most: float) -> Turn:
    """Returns a turn, made smaller if it exceeds `most`, down to none if it is half a circle, which has no one axis."""
    if turn[3] >= math.cos(0.5 * (most - SOFT)):
        return turn
    angle = 2.0 * math.acos(min(max(turn[3], 0.0), 1.0))
    return part_of(turn, soft(angle, most) * smooth((math.pi - angle) / (math.pi - most)) / angle)


@inlined
def turn_head(chains: Chains, s: Array, c: int, look: Turn, character: int, roots: Array, rotations: Array) -> None:
    """Turns neck and head until the head looks at the target; `look` is the way to it before the trunk was turned."""
    world, branch, count = chains.world, chains.firsts[NECK], chains.lengths[NECK]
    slot, whole, neck = c + col.GAZE, whole_of(world, branch), (0.0, 0.0, 0.0, 1.0)
    above, place = rotation_of(world, branch), place_of(world, branch)
    head = above
    for joint in range(count):
        head = times(head, turn_at(rotations, character, chains.columns[NECK, joint]))
    turn = head_turn(chains, look, whole, head, s[slot + col.STEADY])
    part = part_of(turn, s[slot + col.SHOWN] / count)
    for joint in range(count - 1):
        column = chains.columns[NECK, joint]
        place = plus(place, turned(times(neck, above), offset_of(chains, NECK, joint)))
        rotation = times(above, turn_at(rotations, character, column))
        turn_joint(rotations, character, column, part, above)
        above, neck = rotation, times(part, neck)
    if s[slot + col.TARGET] == col.POINT:
        place = plus(place, turned(times(neck, above), offset_of(chains, NECK, count - 1)))
        look = way_from(s, c, slot, character, roots, place, True)
        turn = head_turn(chains, look, whole, head, s[slot + col.STEADY])
    turn = times(part_of(turn, s[slot + col.SHOWN]), inverse(neck))
    turn_joint(rotations, character, chains.columns[NECK, count - 1], turn, times(neck, above))


@inlined
def head_turn(chains: Chains, look: Turn, whole: Turn, head: Turn, steady: float) -> Turn:
    """Returns the turn of a head that makes it look at the target.

    First the way from the heading to the target, less what the trunk was turned: upward, then to the side, so that the
    head does not tilt. Then the rest, by the shortest way.
    """
    way = times(look, inverse(whole))
    gaze = turned(times(way, head), (chains.gaze[0], chains.gaze[1], chains.gaze[2]))
    return times(part_of(bounded(between(gaze, forward_of(look)), MOST_REST), steady), way)
