"""The scores of pairs and clips: all numbers of the quality report, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.quality.additive import add
from bench.quality.dissection import Dissection, dissect
from bench.quality.measures import (
    change_within_halves,
    hurry,
    mismatch,
    neck_excursion,
    neck_jitter,
    posture_angle,
    promised_posture,
    upper_body_errors,
)
from bench.quality.rhythm import concentration, knee_passes, lag_error
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.preparation.repetition import stride_to_stride
from motionsplice.precompute.splice import sampled_offsets, splice_exact, splice_standing
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.expectation import expectation
from motionsplice.runtime.requests import Posture
from motionsplice.runtime.splice import Splice

WRAP = -0.5  # action frames: a longer step back is a jump by whole strides


@dataclass(frozen=True)
class Form:
    """A form of splice to score: its method and its posture.

    how: "naive" (plain replacement), "additive" (what game engines offer), "exact" (the papers' whole-clip splice) or
    "splice" (the bank's).
    """

    how: str
    posture: Posture = "relative"

    @property
    def label(self) -> str:
        return self.how if self.posture == "relative" else f"{self.how} {self.posture}"


@dataclass(frozen=True)
class MethodScore:
    """The scores of one splice of one pair. None where a number has no meaning.

    error, worst_error: mean and 95th percentile of the upper body's error over joints and frames, cm.
    ratio: mean error divided by that of the naive splice over the same frames.
    posture: angle from the posture that the form promises, degrees.
    lag: timing of the arms relative to the legs, minus that of the truth (or the locomotion), degrees of a stride.
    jitter, excursion: motion of the neck over the root, divided by that of the larger source.
    monotone: whether the action's time always increases.
    slopes: smallest and largest speed of the action's time, relative to its own speed.
    hands: how fast hands move as seen from the chest, divided by how fast they do in the action: 99th percentiles.
    mismatch: distance of the legs at aligned frames, cm.
    change: largest angle of a joint in either half from its source, degrees.
    """

    method: str
    seconds: float
    error: float | None
    worst_error: float | None
    ratio: float | None
    posture: float | None
    lag: float | None
    jitter: float
    excursion: float
    monotone: bool | None
    slopes: tuple[float, float] | None
    hands: float | None
    mismatch: float | None
    change: float | None


@dataclass(frozen=True)
class PairScore:
    """The scores of one pair.

    floor: difference of the truth from itself a stride later, cm. expected: error of the bank's splice divided by plain
    replacement's, as `expectation` estimates it without the truth. lacks: the error of the bank's splice taken apart.
    """

    locomotion: str
    action: str
    truth: str
    floor: float | None
    expected: float | None
    lacks: Dissection | None
    methods: tuple[MethodScore, ...]

    @property
    def name(self) -> str:
        return f"{self.locomotion} <- {self.action}"

    @property
    def oracle(self) -> float | None:
        """Error of a splice that knows the truth, cm."""
        return None if self.lacks is None else self.lacks.oracle

    @property
    def lacking(self) -> dict[str, float]:
        """The errors of `lacks` by name, each divided by plain replacement's; empty if the truth is unknown."""
        naive = self.methods[0].error
        if self.lacks is None or naive is None:
            return {}
        parts = {"lag": self.lacks.lag, "time": self.lacks.time, "torso": self.lacks.torso, "oracle": self.lacks.oracle}
        return {name: error / naive for name, error in parts.items()}

    def of(self, method: str) -> MethodScore:
        return next(one for one in self.methods if one.method == method)


@dataclass(frozen=True)
class ClipScore:
    """The scores of one clip.

    strides: strides found in the clip. passes: passes of the left knee by the right. strides_between: strides between
    the first and the last pass. concentration: how similar the phases at the passes are, 1 if all are equal.
    shoulder_motion: for an action, the motion of its shoulders beyond its neutral's gait, degrees.
    """

    clip: str
    kind: str
    strides: float
    passes: int
    strides_between: float
    concentration: float | None
    shoulder_motion: float | None


@dataclass(frozen=True, eq=False)
class Spliced:
    """One splice of a pair. action_frames: the action's frame at each of its frames; None for the naive splice."""

    form: Form
    clip: Clip
    action_frames: Floats | None


def splice_pair(evaluator: Evaluator, locomotion: str, action: str, form: Form) -> Spliced:
    """Splices a pair in one form. Raises MotionError."""
    bank = evaluator.bank
    if form.how == "naive":
        return Spliced(form, _replaced(evaluator, locomotion, action), None)
    if form.how == "additive":
        added = add(bank.motion(locomotion), _replaced(evaluator, locomotion, action), bank.roles)
        return Spliced(form, added, None)
    if form.how == "splice":
        frames = evaluator.action_frames(Splice(locomotion, action), evaluator.frame_times(locomotion))
        return Spliced(form, evaluator.clip(Splice(locomotion, action, posture=form.posture)), frames)
    assert form.posture != "running"
    clips, standing = (bank.motion(locomotion), bank.motion(action)), bank.standing(action)
    if standing is not None and form.posture == "relative":
        return Spliced(form, splice_standing(*clips, bank.roles, standing), None)
    offsets = bank.torso(locomotion).offsets, bank.torso(action).offsets
    exact = splice_exact(*clips, bank.roles, posture=form.posture, torso_offsets=offsets)
    return Spliced(form, exact.clip, exact.action_frames)


def _replaced(evaluator: Evaluator, locomotion: str, action: str) -> Clip:
    return evaluator.clip(Splice(locomotion, action, method="naive"))


def score_pair(
    evaluator: Evaluator, locomotion: str, action: str, truth: Clip | None, splices: Sequence[Spliced]
) -> PairScore:
    """Scores the splices of one pair against its truth, if known. `splices` must contain the naive splice."""
    bank, roles = evaluator.bank, evaluator.bank.roles
    clip_l, clip_u = bank.motion(locomotion), bank.motion(action)
    phase, naive = bank.phase(locomotion), next(one.clip for one in splices if one.form.how == "naive")
    sources = [max(measure(clip, roles) for clip in (clip_l, clip_u)) for measure in (neck_jitter, neck_excursion)]
    scores, lacks, floor = [], None, None
    for one in splices:
        used, frames = clip_l.frames(0, one.clip.frame_count), one.action_frames
        error = worst = ratio = posture = slopes = apart = change = None
        if truth is not None:
            errors = upper_body_errors(one.clip, truth, roles)
            error, worst = 100.0 * errors.mean(), 100.0 * np.percentile(errors, 95)
            ratio = errors.mean() / upper_body_errors(naive.frames(0, one.clip.frame_count), truth, roles).mean()
        if frames is not None:
            sampled_action = bank.motion(action, seam=one.form.how == "splice")
            turns = quaternion.multiply(
                sampled_offsets(bank.torso(action, seam=True).offsets, frames),
                quaternion.conjugate(bank.torso(locomotion).offsets[: len(frames)]),
            )
            promised = promised_posture(used, clip_u, turns, one.form.posture, roles)
            posture = np.degrees(posture_angle(measure_torso(one.clip, roles).posture, promised))
            steps = np.diff(frames)
            steps = steps[steps > WRAP] * clip_l.rate / clip_u.rate
            slopes = (float(steps.min()), float(steps.max()))
            apart = 100.0 * float(np.sqrt(np.mean(mismatch(used, sampled_action, frames, roles) ** 2)))
            change = float(np.degrees(change_within_halves(one.clip, used, sampled_action.sampled(frames)[1], roles)))
        lag = np.degrees(lag_error(one.clip, truth or clip_l, phase[: one.clip.frame_count], roles))
        scores.append(
            MethodScore(
                method=one.form.label,
                seconds=one.clip.duration,
                error=_known(error),
                worst_error=_known(worst),
                ratio=_known(ratio),
                posture=_known(posture),
                lag=_known(lag),
                jitter=float(neck_jitter(one.clip, roles) / sources[0]),
                excursion=neck_excursion(one.clip, roles) / sources[1],
                monotone=None if slopes is None else bool(slopes[0] > 0.0),
                slopes=slopes,
                hands=hurry(one.clip, clip_u, roles),
                mismatch=apart,
                change=change,
            )
        )
        if truth is not None and frames is not None and one.form == Form("splice"):
            offsets = bank.torso(locomotion).offsets, bank.torso(action, seam=True).offsets
            seamed = bank.motion(action, seam=True)
            lacks = dissect(one.clip, clip_l, seamed, truth, offsets, frames, clip_u.frame_count, roles)
    if truth is not None:
        apart = stride_to_stride(truth, measure_torso(truth, roles).clouds, phase[: truth.frame_count], roles)
        floor = 100.0 * apart if apart > 0.0 else None
    known = expectation(evaluator, Splice(locomotion, action))
    expected = None if known is None else known.ratio
    return PairScore(locomotion, action, truth.name if truth else "", floor, expected, lacks, tuple(scores))


def score_clip(bank: Bank, name: str) -> ClipScore:
    """Scores the phase of one clip by the passes of its knees."""
    entry, phase = bank.clip(name), bank.phase(name)
    passes = knee_passes(bank.motion(name), bank.roles)
    return ClipScore(
        clip=name,
        kind=entry.kind,
        strides=entry.cycles,
        passes=len(passes),
        strides_between=float(phase[passes[-1]] - phase[passes[0]]) if len(passes) else 0.0,
        concentration=_known(concentration(phase[passes])),
        shoulder_motion=float(np.degrees(entry.shoulder_motion)) if entry.kind == "action" else None,
    )


def _known(value: float | None) -> float | None:
    return None if value is None or np.isnan(value) else float(value)
