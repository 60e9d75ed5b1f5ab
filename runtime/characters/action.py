"""An action that a character is to play, as a record and as the numbers of a slot."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Limbs
from motionsplice.runtime.characters.commands import BLEND, mask_of, not_negative, weight_in_range
from motionsplice.runtime.requests import METHODS, POSTURES, Memory, Method, Posture, known, time_fault


@dataclass(frozen=True, slots=True)
class Action:
    """An upper body over what a character plays. The WebSocket's command `act` has the same keys.

    Attributes:
        clip: Name of the clip that gives the upper body.
        when: `now`, in step, at the first moment from `start` on; `phase`, when `start` itself is in step; or
            `left_foot`, `right_foot` or `foot`, when that foot comes down.
        start: Seconds into the clip before which it does not begin.
        blend: Seconds to fade in.
        blend_out: Seconds to fade out before the clip ends, if it does not loop.
        curve: Shape of both fades: `linear`, `smooth`, `ease_in` or `ease_out`.
        weight: How much of the action is shown, 0 to 1.
        mask: Which joints it owns: `upper_body`, `left_arm`, `right_arm`, `arms` or `head`.
        method: `splice`, or `naive` for plain replacement.
        posture: How the action's posture is kept, as in `Splice`.
        loop: Whether it goes on by whole strides at its end.
        own_clock: Whether it plays at its own speed instead of in step; or the two times of the clip, in seconds,
            between which it does.
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
    method: Method = "splice"
    posture: Posture = "relative"
    loop: bool = True
    own_clock: bool | tuple[float, float] = False


def waiting_action(action: Action, bank: Bank, limbs: Limbs, rate: float) -> NDArray[np.float64]:
    """The action as a slot [ACTION_COLUMNS] that waits, for characters evaluated `rate` times a second.

    Raises UnknownClipError, TimeRangeError or SettingsError.
    """
    clip = bank.number(action.clip)
    entry = bank.clips[clip]
    if (fault := time_fault("start", action.start, entry)) is not None:
        raise fault
    own = (0.0, np.inf) if action.own_clock is True else action.own_clock or (np.inf, np.inf)
    if not 0.0 <= own[0] <= own[1]:
        raise SettingsError(f"own_clock {own} is not a range of times", mend="Give two times, the earlier first")
    slot = np.zeros(col.ACTION_COLUMNS)
    slot[col.CLIP], slot[col.KIND] = clip, known(METHODS, "method", action.method)
    slot[col.PHASE], slot[col.FRAME] = bank.phase_at(action.clip, action.start), action.start * entry.rate
    slot[[col.WEIGHT, col.LAGGING, col.GOAL]] = weight_in_range(action.weight)
    slot[col.LASTING], slot[col.CURVE] = not_negative("blend", action.blend), known(col.CURVES, "curve", action.curve)
    slot[col.FADING_OUT], slot[col.LOOP] = not_negative("blend_out", action.blend_out), action.loop
    slot[col.MASK], slot[col.POSTURE] = mask_of(limbs, action.mask), known(POSTURES, "posture", action.posture)
    slot[[col.OWN_FROM, col.OWN_TO]] = np.multiply(own, entry.rate)
    slot[col.REMEMBERED :] = Memory.begin(1, rate).state[0]
    return slot
