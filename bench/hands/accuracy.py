"""Errors of alignments of hands against the true alignment."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from bench.findings import Findings
from bench.hands.sequences import RATE, Sequence, ambiguous
from bench.hands.warping import differences, filtered, from_trunk, scaled_by_spread, warped
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.hands.align import STEADYING, align_hands, steadied
from motionsplice.precompute.hands.banded_warp import medians


def errors(title: str, drawn: list[Sequence]) -> Findings:
    """Measures the errors of alignments in frames: ours, and plain dynamic time warping of several features."""
    aligners: Mapping[str, Callable[[Sequence], Floats]] = {
        "first pass": lambda one: medians(align_hands(one.body, one.hands, RATE).passes[0].path, len(one.truth)),
        "both passes": lambda one: align_hands(one.body, one.hands, RATE).frames,
        "both passes, turned by the trunk": lambda one: align_hands(one.body, one.hands, RATE, by_trunk=True).frames,
        "positions": lambda one: warped(one, from_trunk),
        "derivatives": lambda one: warped(one, differences),
        "derivatives filtered like ours": lambda one: steadied(warped(one, filtered), STEADYING * RATE),
        "filtered, scaled derivatives": lambda one: steadied(
            warped(one, lambda hand: scaled_by_spread(filtered(hand))), STEADYING * RATE
        ),
    }
    errors_of = {name: [np.abs(align(one) - one.truth) for one in drawn] for name, align in aligners.items()}
    findings = Findings(f"{title}: error, frames")
    for name, by_sequence in errors_of.items():
        has_target = name == "both passes"
        every = np.concatenate(by_sequence)
        findings.add(f"{name}, median", float(np.median(every)), most=1.0 if has_target else None)
        findings.add(f"{name}, 95th percentile", float(np.percentile(every, 95.0)), most=6.0 if has_target else None)
    moving = np.concatenate([error[one.moving] for error, one in zip(errors_of["both passes"], drawn, strict=True)])
    findings.add("both passes, median while a hand moves", float(np.median(moving)))
    findings.add("both passes, 95th percentile while a hand moves", float(np.percentile(moving, 95.0)))
    ours = np.concatenate(errors_of["both passes"])
    for other in list(aligners)[3:]:
        theirs, most = np.concatenate(errors_of[other]), 0.3 if other in ("positions", "derivatives") else None
        findings.add(f"mean of both passes / mean of {other}", float(ours.mean() / theirs.mean()), most=most)
        findings.add(
            f"median of both passes / median of {other}", float(np.median(ours) / np.median(theirs)), most=most
        )
    return findings


def mismatches(drawn: list[Sequence]) -> Findings:
    """Measures the mismatch of hands that make the body's gestures, and of hands that make other gestures."""
    findings = Findings("Mismatch of phases (0: identical gestures)")
    for label, shift in (("hands of the same sequence", 0), ("hands of another sequence", 1)):
        others = drawn[shift:] + drawn[:shift]
        mismatch = [align_hands(one.body, other.hands, RATE).mismatch for one, other in zip(drawn, others, strict=True)]
        findings.add(f"{label}, median", float(np.median(mismatch)))
        findings.add(f"{label}, {'smallest' if shift else 'largest'}", float(min(mismatch) if shift else max(mismatch)))
    return findings


def constrained(count: int) -> Findings:
    """Measures the errors for identical gestures that the hands partly repeat, with and without frame pairs."""
    findings = Findings(f"{count} ambiguous sequences: mean error, frames")
    without, with_pairs = list[float](), list[float]()
    farthest = 0.0
    for seed in range(count):
        one, pairs, order = ambiguous(seed)
        for used in ((), pairs):
            frames = align_hands(one.body, one.hands, RATE, pairs=used).frames
            (with_pairs if used else without).append(
                float(np.abs(order[frames.round().astype(int)] - one.truth).mean())
            )
        farthest = max(farthest, *(abs(frames[pair.body] - pair.hands) - pair.tolerance for pair in pairs))
    findings.add("without pairs, median over sequences", float(np.median(without)))
    findings.add("with three pairs, median over sequences", float(np.median(with_pairs)))
    findings.add("with pairs / without, means", float(np.mean(with_pairs) / np.mean(without)), most=1.0)
    findings.add("sequences that pairs made worse", float(np.sum(np.array(with_pairs) > without)), "{:.0f}", most=0)
    findings.add("largest distance from a pair beyond its tolerance", farthest, "{:.4f}", most=1e-9)
    return findings
