"""Checks the arguments of commands to characters, and turns them into the numbers that wait in a row."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Legs, Limbs
from motionsplice.runtime.characters.clip_references import States, newest_mix
from motionsplice.runtime.requests import known, time_fault

BLEND = 0.3  # seconds, default duration of a fade
MOST = 1e9  # seconds of fades, and times the captured speed

Locomotion = str | Mapping[str, float]


def waiting_group(
    bank: Bank, locomotion: Locomotion, time: float, blend: float, curve: str, loop: bool
) -> tuple[int, NDArray[np.float64]]:
    """Returns columns of a row, NEXT_COUNT and NEXT_TIME to FIRST_HANDS: a group of locomotions that waits to begin.

    Raises UnknownClipError, TimeRangeError or SettingsError.
    """
    weights = shares_of(bank, locomotion)
    for clip in weights:
        if (fault := time_fault("time", time, bank.numbered[clip])) is not None:
            raise fault
    clips, shares = np.zeros((2, col.MOST_MIXED))
    clips[: len(weights)], shares[: len(weights)] = list(weights), list(weights.values())
    settings = (time, not_negative("blend", blend), known(col.CURVES, "curve", curve), loop)
    return len(weights), np.array([*settings, *clips, *shares])


def waiting_hands(bank: Bank, hands: str | None, blend: float, curve: str, weight: float) -> NDArray[np.float64]:
    """Returns hands as a slot [HANDS_COLUMNS] that waits to begin. Raises UnknownClipError or SettingsError."""
    slot = np.zeros(col.HANDS_COLUMNS)
    slot[col.CLIP] = col.BARE if hands is None else bank.hand_number(hands)
    slot[[col.WEIGHT, col.LAGGING, col.GOAL]] = fraction("weight", weight)
    slot[col.LASTING], slot[col.CURVE] = not_negative("blend", blend), known(col.CURVES, "curve", curve)
    return slot


def shares_of(bank: Bank, locomotion: Locomotion) -> dict[int, float]:
    """Returns weights by clip number, scaled to a sum of 1. Raises UnknownClipError or SettingsError."""
    given = {locomotion: 1.0} if isinstance(locomotion, str) else dict(locomotion)
    total = sum(given.values())
    if not 1 <= len(given) <= col.MOST_MIXED:
        raise SettingsError(f"{len(given)} locomotions cannot be mixed", mend=f"Name 1 to {col.MOST_MIXED}")
    if not (min(given.values()) >= 0.0 and 0.0 < total < np.inf):
        raise SettingsError("the weights of locomotions must be 0 or more, finite, and not all 0")
    return {bank.number(name): weight / total for name, weight in given.items()}


def change_mix(bank: Bank, state: States, rows: NDArray[np.int64], weights: Mapping[str, float]) -> None:
    """Changes the weights of each row's newest group. Raises UnknownClipError or SettingsError, and changes nothing."""
    given, goals = shares_of(bank, weights), []
    for row in rows:
        clips, at = newest_mix(state[row])
        if missing := given.keys() - set(clips):
            name = bank.numbered[min(missing)].name
            raise SettingsError(f"{name!r} is not one of the locomotions being mixed", mend="Play it first")
        goals.append((row, at, [given.get(clip, 0.0) for clip in clips]))
    for row, at, shares in goals:
        state[row, at] = shares


def mask_of(limbs: Limbs, name: str) -> int:
    """Returns the bits of a mask. Raises SettingsError if it is unknown or the rig has no such limbs."""
    mask = known(col.MASKS, "mask", name)
    parts = [part for part in range(1, col.PARTS) if mask >> part & 1]
    if mask != col.UPPER_BODY and not limbs.lengths[parts].all():
        problem = f"mask {name!r} does not fit this rig: its roles do not name these limbs"
        raise SettingsError(problem, mend="Name the joints of the limbs as roles, and build the bank again")
    return mask


def fraction(label: str, value: float) -> float:
    """Returns the value. Raises SettingsError if it is NaN or outside 0 to 1."""
    if not 0.0 <= value <= 1.0:
        raise SettingsError(f"{label} {value} lies outside 0 to 1")
    return value


def lockable(legs: Legs, lock: bool) -> bool:
    """Returns whether feet are to be locked. Raises SettingsError if they are, but the rig has no such legs."""
    if lock and not legs.counts.all():
        problem = "feet cannot be locked on this rig: its roles do not name chains of hip, knee and ankle"
        raise SettingsError(problem, mend="Name the joints of the legs as roles, and build the bank again")
    return lock


def not_negative(label: str, value: float) -> float:
    """Returns the value. Raises SettingsError if it is negative, above MOST or NaN."""
    if not 0.0 <= value <= MOST:
        raise SettingsError(f"{label} {value} must be a number from 0 to {MOST:g}")
    return value
