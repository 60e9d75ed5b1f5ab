"""Targets of characters: which way they lie, how far a body turns to them, and how it gets there smoothly.

Directions are a yaw to the left and a pitch upward from the character's heading, radians.
"""

from __future__ import annotations

import math

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.kernels.curves import smooth
from motionsplice.runtime.kernels.turns import Turn
from motionsplice.runtime.simd.compiled import Array, inlined, kernel

SOFT = math.radians(10.0)  # this far below a limit, turns begin to stay behind the target
STEEP = math.radians(45.0)  # beyond this pitch, and beyond the limit, the yaw of a direction counts less and less
NEAR = 0.1  # metres: targets that are nearer than this turn nobody
SETTLED = 1e-4  # of a weight, or of an angle: less is no longer seen
SHORTEST = 1e-6  # seconds: changes within less would be too steep for their derivatives to be numbers
PACE = 7.0  # changes settle to 3 % of themselves within their duration


@kernel
def advance_aims(s: Array, c: int, seconds: float) -> None:
    """Advances what is shown of each target toward what is wanted; forgets targets that have faded out."""
    count = 0.0
    for part in range(4):
        slot = c + col.FIRST_AIM + part * col.AIM_COLUMNS
        if s[slot + col.TARGET] != col.NOTHING:
            advance_aim(s, slot, seconds)
            count += 1.0 if s[slot + col.TARGET] != col.NOTHING else 0.0
    s[c + col.AIMED] = count


@inlined
def advance_aim(s: Array, slot: int, seconds: float) -> None:
    lasting = s[slot + col.SETTLING]
    pace = PACE / max(lasting, SHORTEST) if lasting > 0.0 else 0.0
    for number in range(3):  # weight, spine, steady
        wanted, at = s[slot + col.WANTED_WEIGHT + number], slot + col.SHOWN + 3 * number
        s[at] -= wanted
        settle(s, at, pace, seconds)
        s[at] = min(max(s[at] + wanted, 0.0), 1.0)
    settle(s, slot + col.YAW_LEFT, pace, seconds)
    settle(s, slot + col.PITCH_LEFT, pace, seconds)
    if s[slot + col.SHOWN] == 0.0 and s[slot + col.WANTED_WEIGHT] == 0.0:
        s[slot + col.TARGET] = col.NOTHING


@inlined
def settle(s: Array, at: int, pace: float, seconds: float) -> None:
    """Moves a difference, followed by its first two derivatives, toward 0, without a jump in any of them.

    Three low-pass filters in a row of the same `pace` per second, solved exactly.
    """
    left, speed, change = s[at], s[at + 1], s[at + 2]
    if left == 0.0 and speed == 0.0 and change == 0.0:
        return
    b, c, decay = speed + pace * left, 0.5 * change + pace * speed + 0.5 * pace * pace * left, math.exp(-pace * seconds)
    left = (left + (b + c * seconds) * seconds) * decay
    slope = (b + 2.0 * c * seconds) * decay
    speed = slope - pace * left
    change = 2.0 * c * decay - pace * (slope + speed)
    if pace == 0.0 or (abs(left) < SETTLED and abs(speed) < pace * SETTLED):
        left = speed = change = 0.0
    s[at], s[at + 1], s[at + 2] = left, speed, change


@inlined
def way_to(s: Array, slot: int, x: float, y: float, z: float, is_final: bool) -> Turn:
    """Returns the turn of Z that is shown of a target at x, y, z: upward, then to the left, within a slot's limits.

    Up to SOFT below a limit this is the target's own direction. Behind the back the yaw falls to 0 again, so that it
    does not jump from one side to the other. The call for the place from which the target is finally seen, `is_final`,
    remembers the way, so that after a change of the target what is shown begins where it was.
    """
    level = math.sqrt(x * x + z * z)
    length = math.sqrt(level * level + y * y)
    wanted_yaw, wanted_pitch, most = math.atan2(x, z), math.atan2(y, level), s[slot + col.MOST_YAW]
    near = smooth(length / NEAR) if s[slot + col.TARGET] == col.POINT else 1.0
    behind = smooth((math.pi - abs(wanted_yaw)) / (math.pi - max(most, 0.5 * math.pi)))
    flat, steep = max(STEEP, s[slot + col.MOST_PITCH]), 1.0 if level > 0.0 else 0.0
    if abs(wanted_pitch) > flat and level > 0.0:
        steep = smooth(level / (length * math.cos(flat)))
    yaw = math.copysign(near * steep * behind * soft(abs(wanted_yaw), most), wanted_yaw)
    pitch = math.copysign(near * soft(abs(wanted_pitch), s[slot + col.MOST_PITCH]), wanted_pitch)
    yaw_left, pitch_left = s[slot + col.YAW_LEFT], s[slot + col.PITCH_LEFT]
    if s[slot + col.CHANGED] > 0.0:
        yaw_left, pitch_left = yaw_left + s[slot + col.YAW] - yaw, pitch_left + s[slot + col.PITCH] - pitch
    if is_final:
        s[slot + col.YAW], s[slot + col.PITCH], s[slot + col.CHANGED] = yaw, pitch, 0.0
        s[slot + col.YAW_LEFT], s[slot + col.PITCH_LEFT] = yaw_left, pitch_left
    yaw, pitch = yaw + yaw_left, pitch + pitch_left
    if yaw == wanted_yaw and pitch == wanted_pitch and steep == 1.0:  # without sines: the usual case, in half the time
        cy, cp = math.sqrt(0.5 + 0.5 * z / level), math.sqrt(0.5 + 0.5 * level / length)
        sy, sp = 0.5 * x / (level * cy), 0.5 * y / (length * cp)
    else:
        sy, cy, sp, cp = math.sin(0.5 * yaw), math.cos(0.5 * yaw), math.sin(0.5 * pitch), math.cos(0.5 * pitch)
    return -cy * sp, sy * cp, sy * sp, cy * cp


@inlined
def soft(angle: float, most: float) -> float:
    """Returns an angle that is 0 or more, bent so that it never exceeds `most`."""
    bend = min(SOFT, 0.5 * most)
    over = angle - (most - bend)
    if over <= 0.0:
        return angle
    over = over / bend if bend > 0.0 else 2.0
    return most - bend + bend * (over - 0.25 * over * over if over < 2.0 else 1.0)
