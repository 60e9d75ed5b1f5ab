"""Targets of characters: the records, and the columns that they fill."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.commands import fraction, not_negative
from motionsplice.runtime.requests import known

AimPart = Literal["chest", "left_arm", "right_arm"]
PARTS: Mapping[str, int] = {"chest": col.CHEST, "left_arm": col.LEFT, "right_arm": col.RIGHT, "head": col.GAZE}
AIM_PARTS = get_args(AimPart)
LARGEST_YAW, LARGEST_PITCH = math.radians(150.0), math.radians(80.0)
FARTHEST = 1e9  # metres of a point or a place, and radians of a heading
States = NDArray[np.float64]
Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Look:
    """The target of a look: a point or a direction in the world.

    Spine, neck and head share the turn. The head looks exactly at the target, as far as the limits allow. The fields
    have the names of a WebSocket command's keys.

    Attributes:
        point: Where to look, [3] metres.
        direction: Which way to look, [3] of any length; give this or `point`.
        weight: How much of it is visible, 0 to 1.
        spine: Share of the turn that the spine makes, 0 to 1; the rest is that of neck and head.
        steady: How much of the motion's own movement of the head is taken out, 0 to 1: at 1 the gaze rests on the
            target, at 0 the head sways and nods about it as it would without a target.
        max_yaw: Largest turn to either side of the heading, radians, at most 2.61. The turn is exact up to 10 degrees
            below, and goes back behind the character.
        max_pitch: Largest turn up or down, radians, at most 1.39.
    """

    point: Sequence[float] | None = None
    _: KW_ONLY
    direction: Sequence[float] | None = None
    weight: float = 1.0
    spine: float = 0.3
    steady: float = 1.0
    max_yaw: float = 1.4
    max_pitch: float = 0.95


@dataclass(frozen=True, slots=True)
class Aim:
    """The target of an aim: a point or a direction in the world.

    The chest turns as far as the target lies to the side of straight ahead, and above it; the action's arms go along.
    An arm turns about its shoulder until the line from shoulder to wrist points to the target. The fields have the
    names of a WebSocket command's keys.

    Attributes:
        point: Where to aim, [3] metres.
        direction: Which way to aim, [3] of any length; give this or `point`.
        part: What is turned: `chest`, with the spine below it, `left_arm` or `right_arm`. Each may have its own target.
        weight: How much of it is visible, 0 to 1.
        steady: Of the chest: how much of the hands' swivel about the vertical is taken out, 0 to 1. At 1 they stay on
            the side of the target; at 0 the chest sways as it would without a target.
        max_yaw: Largest turn to either side of the heading, radians, as in `Look`.
        max_pitch: Largest turn up or down, radians, as in `Look`.
    """

    point: Sequence[float] | None = None
    _: KW_ONLY
    direction: Sequence[float] | None = None
    part: AimPart = "chest"
    weight: float = 1.0
    steady: float = 0.0
    max_yaw: float = 1.3
    max_pitch: float = 0.85


def target_of(target: Look | Aim, blend: float) -> States:
    """Returns the columns TARGET to SETTLING of what is wanted. Raises SettingsError."""
    if (target.point is None) == (target.direction is None):
        raise SettingsError("a target is a point or a direction", mend="Give one of them")
    is_point = target.point is not None
    label = "point" if is_point else "direction"
    to = np.asarray(target.point if is_point else target.direction, np.float64)
    if to.shape != (3,) or not np.isfinite(to).all() or (is_point and np.abs(to).max() > FARTHEST):
        problem = f"{label} {list(to.flat)} is not three finite numbers"
        raise SettingsError(problem + (f" of at most {FARTHEST:g} metres" if is_point else ""))
    if not is_point:
        if not to.any():
            raise SettingsError("the direction is zero", mend="Give one of any other length")
        to = to / np.abs(to).max()  # first, for squares of huge and of tiny numbers are no numbers
        to = to / np.linalg.norm(to)
    spine = target.spine if isinstance(target, Look) else 0.0
    return np.array(
        [
            *(col.POINT if is_point else col.DIRECTION, *to),
            *(fraction("weight", target.weight), fraction("spine", spine), fraction("steady", target.steady)),
            limit("max_yaw", target.max_yaw, LARGEST_YAW),
            limit("max_pitch", target.max_pitch, LARGEST_PITCH),
            blend,
        ]
    )


def give_target(state: States, rows: Numbers, parts: Sequence[str], target: Look | Aim | None, blend: float) -> None:
    """Gives parts of rows a target, or fades out what they have. Raises SettingsError, and changes nothing."""
    slots = [known(PARTS, "part", part) for part in parts]
    lasting = not_negative("blend", blend)
    wanted = None if target is None else target_of(target, lasting)
    for slot in slots:
        if wanted is None:
            fade_target(state, rows, slot, blend)
        else:
            set_target(state, rows, slot, wanted)
    targets = state[rows[:, None], list(PARTS.values())]
    state[rows, col.AIMED] = np.count_nonzero(targets, axis=1)


def set_target(state: States, rows: Numbers, slot: int, wanted: States) -> None:
    """Gives rows a target for the part whose columns begin at `slot`; `wanted` is from `target_of`."""
    new = rows[state[rows, slot + col.TARGET] == col.NOTHING]
    state[new, slot : slot + col.AIM_COLUMNS] = 0.0
    state[rows, slot : slot + len(wanted)] = wanted
    state[rows, slot + col.CHANGED] = 1.0
    state[new, slot + col.CHANGED] = 0.0
    state[new, slot + col.SPINE] = wanted[col.WANTED_SPINE]
    state[new, slot + col.STEADY] = wanted[col.WANTED_STEADY]
    if wanted[col.SETTLING] == 0.0:
        state[rows, slot + col.CHANGED : slot + col.AIM_COLUMNS] = 0.0
        for number, column in enumerate((col.SHOWN, col.SPINE, col.STEADY)):
            state[rows, slot + column] = wanted[col.WANTED_WEIGHT + number]


def fade_target(state: States, rows: Numbers, slot: int, blend: float) -> None:
    """Fades out what the part whose columns begin at `slot` turns to, within `blend` seconds."""
    state[rows, slot + col.WANTED_WEIGHT] = 0.0
    state[rows, slot + col.SETTLING] = blend
    if blend == 0.0:
        state[rows, slot : slot + col.AIM_COLUMNS] = 0.0


def limit(label: str, value: float, most: float) -> float:
    """Returns a limit of turns. Raises SettingsError if it is NaN or outside 0 to `most` radians."""
    if not 0.0 <= value <= most:
        raise SettingsError(f"{label} {value} lies outside 0 to {most:.2f} radians")
    return value
