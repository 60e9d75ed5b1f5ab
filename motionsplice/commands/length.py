"""How long a splice is: one that its locomotion cuts short, and one whose locomotion repeats."""

from __future__ import annotations

import math

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage

LONGEST = 3600.0  # seconds of a splice
CUT = 0.5  # seconds of an action whose loss is worth a line


def lasting(bank: Bank, splice: Splice, seconds: float) -> Clip:
    """Returns a splice of any length, as a character plays it: the locomotion repeats its loop.

    Raises SettingsError if `seconds` is out of range, or the locomotion is shorter and cannot loop, and MotionError for
    the same reasons as `Evaluator.pose`.
    """
    locomotion = bank.clip(splice.locomotion)
    if not 0.0 < seconds <= LONGEST:
        raise SettingsError(f"cannot write {seconds:g} seconds", mend=f"Give more than 0 and at most {LONGEST:g}")
    if seconds > locomotion.duration + 1.0 / locomotion.rate and locomotion.loop == 0:
        problem = f"{splice.locomotion!r} cannot loop, so it lasts no longer than {locomotion.duration:.2f} s"
        raise SettingsError(problem, mend="Leave out --seconds, or choose a locomotion that loops")
    characters = Characters(Stage(Evaluator(bank)), locomotion.rate)
    rows = characters.add(1, splice.locomotion)
    if splice.action is not None and splice.method != "none":
        action = Action(splice.action, start=splice.start, method=splice.method, posture=splice.posture, blend=0.0)
        characters.act(rows, action)
    if splice.hands is not None:
        characters.wear(rows, splice.hands, blend=0.0)
    poses = characters.stage.evaluator.poses(int(seconds * locomotion.rate + 1e-6) + 1)
    for frame in range(len(poses.flat)):
        if frame > 0:
            characters.advance()
        characters.evaluate(poses.rows(frame, frame + 1))
    return poses.clip(splice.name, bank.skeleton, locomotion.rate)


def cut_short(evaluator: Evaluator, splice: Splice) -> str:
    """Returns a sentence on what the end of the locomotion cuts off the action, or "" if it is hardly anything."""
    if splice.action is None or splice.method == "none":
        return ""
    locomotion, action = (evaluator.bank.clip(name) for name in (splice.locomotion, splice.action))
    played = evaluator.action_frames(splice, evaluator.frame_times(splice.locomotion)) / action.rate
    left = action.duration - float(played[-1])
    if left < CUT or (np.diff(played) < 0.0).any():  # it repeats
        return ""
    if locomotion.loop > 0:
        seconds = math.ceil(10.0 * (locomotion.duration + left)) / 10.0
        mend = f"for all of it, repeat {splice.locomotion!r}: --seconds {seconds:g}"
    else:
        mend = "for more of it, choose a longer locomotion, or one that loops"
    shown = f"{played[-1]:.2f} of {action.duration:.2f} s"
    return f"{splice.action!r} is cut after {shown}, where {splice.locomotion!r} ends; {mend}"
