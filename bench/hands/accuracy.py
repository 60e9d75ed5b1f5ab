"""How far alignments of hands are off the truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from bench.findings import Findings
from bench.hands.sequences import RATE, Sequence, ambiguous
from bench.hands.warping import differences, evened, filtered, seen, warped
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.hands.align import STEADYING, align_hands, steadied
from motionsplice.precompute.hands.banded_warp import medians


def errors(title: str, drawn: list[Sequence]) -> Findings:
    """Frames by which alignments are off the truth."""
    ways: Mapping[str, Callable[[Sequence], Floats]] = {
        "first pass": lambda one: medians(align_hands(one.body, one.hands, RATE).passes[0].path, len(one.truth)),
        "both passes": lambda one: align_hands(one.body, one.hands, RATE).frames,
        "both, turned by the trunk": lambda one: align_hands(one.body, one.hands, RATE, by_trunk=True).frames,
        "positions": lambda one: warped(one, seen),
        "derivatives": lambda one: warped(one, differences),
        "derivatives, filtered as ours": lambda one: steadied(warped(one, filtered), STEADYING * RATE),
        "the same, each clip's over its spread": lambda one: steadied(
            warped(one, lambda hand: evened(filtered(hand))), STEADYING * RATE
        ),
    }
    off = {name: [np.abs(way(one) - one.truth) for one in drawn] for name, way in ways.items()}
    told = Findings(f"{title}: frames off the truth")
    for name, found in off.items():
        alone = name == "both passes"
        every = np.concatenate(found)
        told.add(f"{name}, median", float(np.median(every)), most=1.0 if alone else None)
        told.add(f"{name}, 95th percentile", float(np.percentile(every, 95.0)), most=6.0 if alone else None)
    moving = np.concatenate([found[one.moving] for found, one in zip(off["both passes"], drawn, strict=True)])
    told.add("both passes, median while a hand moves", float(np.median(moving)))
    told.add("both passes, 95th percentile while a hand moves", float(np.percentile(moving, 95.0)))
    ours = np.concatenate(off["both passes"])
    for other in list(ways)[3:]:
        theirs, most = np.concatenate(off[other]), 0.3 if other in ("positions", "derivatives") else None
        told.add(f"mean over that of {other}", float(ours.mean() / theirs.mean()), most=most)
        told.add(f"median over that of {other}", float(np.median(ours) / np.median(theirs)), most=most)
    return told


def mismatches(drawn: list[Sequence]) -> Findings:
    """What hands that do the body's gestures and hands that do others' are told apart by."""
    told = Findings("Mismatch of phases")
    for label, apart in (("the body's own hands", 0), ("another's", 1)):
        others = drawn[apart:] + drawn[:apart]
        found = [align_hands(one.body, other.hands, RATE).mismatch for one, other in zip(drawn, others, strict=True)]
        told.add(f"{label}, median", float(np.median(found)))
        told.add(f"{label}, {'most' if not apart else 'least'}", float(min(found) if apart else max(found)))
    return told


def constrained(count: int) -> Findings:
    """Equal gestures, a part of which the hands' performer does twice; pairs name where three of them are."""
    told = Findings(f"{count} ambiguous sequences: frames off the truth, means")
    without, given = list[float](), list[float]()
    missed = 0.0
    for seed in range(count):
        one, pairs, order = ambiguous(seed)
        for some in ((), pairs):
            frames = align_hands(one.body, one.hands, RATE, pairs=some).frames
            (given if some else without).append(float(np.abs(order[frames.round().astype(int)] - one.truth).mean()))
        missed = max(missed, *(abs(frames[pair.body] - pair.hands) - pair.tolerance for pair in pairs))
    told.add("without pairs, median over sequences", float(np.median(without)))
    told.add("with three pairs", float(np.median(given)))
    told.add("with over without, means", float(np.mean(given) / np.mean(without)), most=1.0)
    told.add("sequences that pairs made worse", float(np.sum(np.array(given) > without)), "{:.0f}", most=0)
    told.add("farthest from a pair beyond its tolerance", missed, "{:.4f}", most=1e-9)
    return told
