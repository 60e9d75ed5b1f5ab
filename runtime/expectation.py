"""How far a splice can be trusted: the error to expect of it, and of plain replacement, without knowing the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.comparison import legs_apart
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Memory, Poses
from motionsplice.runtime.splice import Splice

RATE = 30.0  # moments per second at which both clips are compared
MOST = 300  # moments: of a run of ten minutes, their means are within 5 % of those of all
GOLDEN = 0.6180339887498949  # multiples of it are spread evenly, and repeat nothing
REPETITIONS = 1.5  # errors of a repetition: two performances differ by more than one from its own mean
LEGS = 0.4  # of the distance of the legs that shows in the upper body
LITTLE = 0.8  # of plain replacement's error: a splice above it is hardly better
GOOD = 0.005  # metres: an error below it is none


@dataclass(frozen=True)
class Expectation:
    """How good a splice of an action with a gait is expected to be. Distances are means over frames and joints, metres.

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
        """Whether plain replacement may be as good, and the splice is not good itself."""
        return self.ratio > LITTLE and self.error >= GOOD


def expectation(evaluator: Evaluator, splice: Splice) -> Expectation | None:
    """Estimates how far a splice can be trusted, by what both clips show.

    The action's own repetition says how much its arms follow the stride at all, the legs' distance how exactly the
    stride was found; both add up as independent errors. Plain replacement is off by about as much as both results
    differ: what does not repeat is in its error and in their difference alike. `python -m bench.quality` compares these
    numbers with the truth.

    At most MOST moments are compared, so the time it takes does not grow with the length of either clip.

    Args:
        evaluator: The evaluator of the bank.
        splice: What to splice; its method does not matter.

    Returns:
        None without an action, or for one that stands or has stretches, whose time does not follow the legs.

    Raises:
        UnknownClipError: The bank has no such clip or hands, or the hands are not aligned to the action.
        TimeRangeError: `start` is NaN or outside the action.
        SettingsError: The posture is unknown.

    Example:
        ```python
        from motionsplice import Bank, Evaluator, Splice, expectation

        found = expectation(Evaluator(Bank.open("demo/bank")), Splice("walk", "carry_box"))
        print(f"{100 * found.error:.1f} cm off, plain replacement {100 * found.replaced:.1f} cm")
        ```
    """
    bank, splice = evaluator.bank, replace(splice, method="splice")
    if splice.action is None or not bank.clip(splice.action).gait or bank.clip(splice.action).stretches:
        return None
    locomotion, action = bank.clip(splice.locomotion), bank.clip(splice.action)
    step = max(1, int(locomotion.rate / RATE))
    moments = some_of(np.arange(0, locomotion.frame_count - 1, step), MOST)
    later = np.minimum(moments + step, locomotion.frame_count - 1)
    frames, next_frames = (evaluator.action_frames(splice, at / locomotion.rate) for at in (moments, later))
    paces = (next_frames - frames) / (later - moments) * locomotion.rate / action.rate
    paces = paces[paces > 0.0]  # a step back is a jump by whole strides
    own, other = bank.motion_at(splice.locomotion, moments.astype(np.float64)), bank.motion_at(splice.action, frames)
    apart = legs_apart(_places(evaluator, _poses(own)), _places(evaluator, _poses(other)), bank.roles)
    legs = float(np.sqrt(np.mean(apart**2)))
    error = float(np.hypot(REPETITIONS * action.repetition, LEGS * legs))
    times = moments / locomotion.rate
    spliced, replaced = (_upper_body(evaluator, replace(splice, method=one), times) for one in ("splice", "naive"))
    return Expectation(
        legs=legs,
        repetition=action.repetition,
        slowest=float(paces.min()) if len(paces) else 1.0,
        fastest=float(paces.max()) if len(paces) else 1.0,
        error=error,
        replaced=max(error, float(np.linalg.norm(spliced - replaced, axis=2).mean())),
    )


def _upper_body(evaluator: Evaluator, splice: Splice, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns the joints above the pelvis relative to the root [n, joints, 3], in metres, at `times` [n]."""
    places = _places(evaluator, evaluator.sequence(splice, times, memory=Memory.begin(1, RATE)))
    return places[:, evaluator.bank.skeleton.subtree(evaluator.bank.roles.pelvis)[1:]] - places[:, :1]


def _places(evaluator: Evaluator, poses: Poses) -> NDArray[np.float64]:
    """Returns the world positions [n, J, 3] of all joints, in metres."""
    world = np.empty((*poses.rotations.shape[:2], 3), np.float32)
    evaluator.world_positions(poses, world)
    return world.astype(np.float64)


def _poses(clip: Clip) -> Poses:
    return Poses(clip.root_positions.astype(np.float32), clip.rotations.astype(np.float32))


def some_of(moments: NDArray[np.int64], most: int) -> NDArray[np.int64]:
    """Returns at most `most` of the moments [n], in order, spread over all of them.

    They are not evenly spaced: at even distances of about a stride, all would show the same part of it.
    """
    if len(moments) <= most:
        return moments
    places = np.arange(most)
    return moments[((places + places * GOLDEN % 1.0) * len(moments) / most).astype(np.int64)]
