"""Actions for characters: the record, and the slot that it fills."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Limbs
from motionsplice.runtime.characters.commands import BLEND, fraction, mask_of, not_negative
from motionsplice.runtime.requests import METHODS, POSTURES, Memory, Posture, known, time_fault

ActionMethod = Literal["splice", "naive"]
ACTION_METHODS = {name: number for name, number in METHODS.items() if name != "none"}


@dataclass(frozen=True, slots=True)
class Action:
    """An upper body to play over a character's locomotion.

    The WebSocket's command `act` has the same keys, except that it calls the clip `action`.

    Attributes:
        clip: Name of the clip that gives the upper body.
        when: When the action begins. `now`: at once, at the first frame from `start` on that is in step. `phase`: as
            soon as the locomotion is in step with `start`. `left_foot`, `right_foot` or `foot`: when this foot, or
            either, touches down.
        start: Seconds into the clip: its earliest frame.
        blend: Seconds to fade in.
        blend_out: Seconds to fade out before the clip ends, if it does not loop.
        curve: Shape of both fades: `linear`, `smooth`, `ease_in` or `ease_out`.
        weight: Weight of the action over what is below it, 0 to 1.
        mask: The joints that the action owns: `upper_body`, `left_arm`, `right_arm`, `arms` or `head`.
        method: `splice`, or `naive` for plain replacement.
        posture: How the action's posture is kept, as in `Splice`.
        loop: Whether the action jumps back by whole strides at its end and goes on, instead of fading out.
        own_clock: Whether the action plays at its own speed instead of in step; or a pair of times of the clip, in
            seconds, between which it does. None: yes for a standing action, no for any other, which then plays at 1.75
            times its captured speed at most; a clip that stands and walks by turns does both. False: no, at any speed.
    """

    clip: str
    _: KW_ONLY
    when: col.When = "now"
    start: float = 0.0
    blend: float = BLEND
    blend_out: float = BLEND
    curve: col.Curve = "smooth"
    weight: float = 1.0
    mask: col.Mask = "upper_body"
    method: ActionMethod = "splice"
    posture: Posture = "relative"
    loop: bool = True
    own_clock: bool | tuple[float, float] | None = None


def waiting_action(action: Action, bank: Bank, limbs: Limbs, rate: float) -> NDArray[np.float64]:
    """Returns the action as a slot [ACTION_COLUMNS] that waits to begin; `rate` is in evaluations per second.

    Raises UnknownClipError, TimeRangeError or SettingsError.
    """
    entry, start, leaving = bank.clip(action.clip), action.start, 0.0
    if (fault := time_fault("start", start, entry)) is not None:
        raise fault
    if entry.stretches and action.method == "splice":
        if action.own_clock is not None:
            problem = f"own_clock of {action.clip!r} is that of its stretches, which stand and walk by turns"
            raise SettingsError(problem, mend=f"Leave it out, or play one of {', '.join(entry.stretches)}")
        name = max((one for one in entry.stretches if bank.begin_of(one) <= start), key=bank.begin_of)
        entry, leaving = bank.clip(name), col.PLAYS_ON
        start += entry.enters / entry.rate - bank.begin_of(name)
    asked = entry.stands if action.own_clock is None else action.own_clock
    own = (0.0, np.inf) if asked is True else asked or (np.inf, np.inf)
    if not 0.0 <= own[0] <= own[1]:
        raise SettingsError(
            f"own_clock {own} is not a range of times", mend="Give start and end in seconds, the start first"
        )
    slot = np.zeros(col.ACTION_COLUMNS)
    slot[col.CLIP], slot[col.KIND] = bank.number(entry.name), known(ACTION_METHODS, "method", action.method)
    slot[col.PHASE], slot[col.FRAME] = bank.phase_at(entry.name, start), start * entry.rate
    slot[[col.WEIGHT, col.LAGGING, col.GOAL]] = fraction("weight", action.weight)
    slot[col.LASTING], slot[col.CURVE] = not_negative("blend", action.blend), known(col.CURVES, "curve", action.curve)
    slot[col.FADING_OUT], slot[col.LOOP] = not_negative("blend_out", action.blend_out), action.loop
    slot[col.MASK], slot[col.POSTURE] = mask_of(limbs, action.mask), known(POSTURES, "posture", action.posture)
    slot[[col.OWN_FROM, col.OWN_TO]] = np.multiply(own, entry.rate)
    if action.own_clock is False:
        slot[col.OWN_TO] = col.ANY_PACE
    slot[col.LEAVING] = leaving
    slot[col.REMEMBERED :] = Memory.begin(1, rate).state[0]
    return slot


def waiting_stop(blend: float, curve: str) -> NDArray[np.float64]:
    """Returns a slot [ACTION_COLUMNS] that waits to fade in the locomotion's own upper body. Raises SettingsError."""
    slot = np.zeros(col.ACTION_COLUMNS)
    slot[col.KIND], slot[col.MASK] = col.OWN, col.UPPER_BODY
    slot[col.LASTING], slot[col.CURVE] = not_negative("blend", blend), known(col.CURVES, "curve", curve)
    return slot


def running_rows(state: NDArray[np.float64]) -> NDArray[np.int64]:
    """Returns the indices of rows [n, COLUMNS] that have an action of posture `running`."""
    slots = np.arange(col.MOST_ACTIONS)
    running = state[:, col.FIRST_ACTION + slots * col.ACTION_COLUMNS + col.POSTURE] == POSTURES["running"]
    return np.flatnonzero((running & (slots < state[:, [col.ACTIONS]])).any(axis=1))
