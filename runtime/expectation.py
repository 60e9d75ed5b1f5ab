"""How far a splice can be trusted: the error to expect of it, and of plain replacement, without knowing the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motionsplice.motion.comparison import at_frames, legs_apart, over_root
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice

RATE = 30.0  # moments per second at which both clips are compared
REPETITIONS = 1.5  # errors of a repetition: two performances differ by more than one from its own mean
LEGS = 0.4  # of the distance of the legs that shows in the upper body
LITTLE = 0.8  # of plain replacement's error: a splice above it is hardly better


@dataclass(frozen=True)
class Expectation:
    """What to expect of a splice of an action with a gait. Distances are means over frames and joints, metres.

    Attributes:
        legs: Distance of root and knees of both clips at the frames that are spliced.
        repetition: Distance of the action's upper body from itself a stride later; 0 if the clip is too short to know.
        slowest: Least speed of the action, in seconds of the action per second.
        fastest: Largest speed of the action.
        error: Expected distance of the upper body from that of the same person doing both.
        replaced: Expected distance for plain replacement.
    """

    legs: float
    repetition: float
    slowest: float
    fastest: float
    error: float
    replaced: float

    @property
    def ratio(self) -> float:
        """The expected error, divided by that of plain replacement."""
        return self.error / self.replaced if self.replaced > 0.0 else 1.0

    @property
    def gains_little(self) -> bool:
        """Whether plain replacement may be as good."""
        return self.ratio > LITTLE


def expectation(evaluator: Evaluator, splice: Splice) -> Expectation | None:
    """Estimates how far a splice can be trusted, by what both clips show.

    The action's own repetition says how much its arms follow the stride at all, the legs' distance how exactly the
    stride was found; both add up as independent errors. Plain replacement is off by about as much as both results
    differ: what does not repeat is in its error and in their difference alike. `python -m bench.quality` compares these
    numbers with the truth.

    Args:
        evaluator: The evaluator of the bank.
        splice: What to splice; its method does not matter.

    Returns:
        None without an action, or for one that stands or has stretches, whose time does not follow the legs.

    Raises:
        UnknownClipError: The bank has no such clip.
    """
    bank = evaluator.bank
    if splice.action is None or not bank.clip(splice.action).gait or bank.clip(splice.action).stretches:
        return None
    locomotion, action = bank.clip(splice.locomotion), bank.clip(splice.action)
    moments = np.arange(0, locomotion.frame_count, max(1, int(locomotion.rate / RATE)))
    frames = evaluator.action_frames(splice, evaluator.frame_times(splice.locomotion))[moments]
    steps = np.diff(frames) / np.diff(moments) * locomotion.rate / action.rate
    steps = steps[steps > 0.0]  # a step back is a jump by whole strides
    shown = bank.motion(splice.locomotion), bank.motion(splice.action, seam=True)
    legs = float(np.sqrt(np.mean(legs_apart(shown[0], moments, shown[1], frames, bank.roles) ** 2)))
    error = float(np.hypot(REPETITIONS * action.repetition, LEGS * legs))
    forms = [evaluator.clip(replace(splice, method=method)) for method in ("splice", "naive")]
    both = moments[moments < min(clip.frame_count for clip in forms)]
    spliced, replaced = (over_root(at_frames(clip, both), bank.roles) for clip in forms)
    return Expectation(
        legs=legs,
        repetition=action.repetition,
        slowest=float(steps.min(initial=1.0)),
        fastest=float(steps.max(initial=1.0)),
        error=error,
        replaced=max(error, float(np.linalg.norm(spliced - replaced, axis=2).mean())),
    )
