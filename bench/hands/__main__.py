"""How well hands are aligned to bodies, against generated truth: `python -m bench.hands [CLIPS]`.

sequences    gestures like the paper's (6 to 34 in 280 to 570 frames at 60 Hz, each of the hands' 0.2 to 1 times as
             large as the body's, tempo 0.6 to 1.6, 2 mm of noise): frames by which alignments are off the truth, beside
             plain dynamic time warping of positions and of derivatives (the paper's figure 3) in the same band, as seen
             from the trunks; and of derivatives that are filtered, and a result that is steadied, as ours are.
real         the arms of each clip in a folder, and once more 0.2 to 1 times as large, turned, and in another tempo.
mismatch     by which a user is warned of hands that do not do what the body does.
pairs        equal gestures, of which the hands' performer repeats one: with and without three pairs of frames.
time         one hand of 569 frames, the paper's longest (10.95 s there).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.findings import Findings
from bench.hands.sequences import RATE, Sequence, ambiguous, captured, hands_of, noisy, sequence
from motionsplice.cli import run
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.precompute.hands.align import BANDS, STEADYING, align_hands, steadied
from motionsplice.precompute.hands.banded_warp import Band, cheapest_path, medians, straight_band
from motionsplice.precompute.hands.phases import derivatives
from motionsplice.precompute.hands.points import HandMotion

PARTS = ((0.2, 0.4), (0.4, 0.7), (0.7, 1.0))  # sizes of the hands' gestures


def main(
    clips: Annotated[Path | None, typer.Argument(help="A folder of real motion, whose arms are taken too")] = None,
    sequences: Annotated[int, typer.Option(min=1, help="Generated sequences")] = 50,
) -> None:
    """Prints what is found."""
    if clips is not None:
        errors("Real motion, once more in other tempo and size", captured(clips)).show()
    drawn = [sequence(seed) for seed in range(sequences)]
    errors(f"{sequences} sequences", drawn).show()
    mismatches(drawn).show()
    for size in PARTS:
        some = [sequence(1000 + seed, size) for seed in range(max(sequences // 3, 1))]
        errors(f"hands {size[0]:g} to {size[1]:g} times as large", some).show()
    constrained(sequences).show()
    timing().show()


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


def seen(hand: HandMotion) -> Floats:
    """Points [F, 4, 3] as seen from the trunk."""
    assert hand.trunk is not None
    return rotate(about([0.0, 1.0, 0.0], -hand.trunk)[:, None], hand.points)


def differences(hand: HandMotion) -> Floats:
    """First and second derivatives [F, 8, 3] as seen from the trunk, from neighbouring frames."""
    velocity = np.gradient(seen(hand), 1.0 / RATE, axis=0)
    return np.concatenate([velocity, np.gradient(velocity, 1.0 / RATE, axis=0)], axis=1)


def filtered(hand: HandMotion) -> Floats:
    """The same from a bell of frames, as our own are; metres per second, and per second in 0.1 s."""
    found = derivatives(seen(hand), RATE)
    return np.concatenate([found.velocity, 0.1 * found.acceleration], axis=1)


def evened(values: Floats) -> Floats:
    """Derivatives as a part of what each usually is in its clip."""
    return np.concatenate([one / np.std(one) for one in np.split(values, 2, axis=1)], axis=1)


def warped(one: Sequence, feature: Callable[[HandMotion], Floats]) -> Floats:
    """Plain dynamic time warping [F] by the features [F, n, 3] of both hands, in the band of the first pass."""
    ours, theirs = (
        np.concatenate([feature(hand).reshape(len(hand.points), -1) for hand in side], axis=1)
        for side in (one.body, one.hands)
    )
    band = straight_band(len(ours), len(theirs), BANDS[0], [])
    return medians(cheapest_path(distances(ours, theirs, band), band.low, band.high), len(ours))


def distances(ours: Floats, theirs: Floats, band: Band) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    costs = np.zeros((len(ours), band.width), np.float32)
    for row, low, high, one in zip(costs, band.low, band.high, ours, strict=True):
        row[: high - low + 1] = np.sum((theirs[low : high + 1] - one) ** 2, axis=1)
    return costs


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


def timing() -> Findings:
    """Seconds that an alignment takes, warm, the median of 20, and how that grows."""
    told = Findings("Seconds for one hand, warm")
    taken = {}
    for frames in (569, 1138, 2276):
        pair = gesture_pair(5, gestures=frames // 40, seconds=(frames - 1) / RATE, hand="right")
        draw = np.random.default_rng(0)
        body, hands = noisy(hands_of(pair.body), draw)[1:], noisy(hands_of(pair.hands), draw)[1:]
        bands = BANDS[0] * 569 / frames, BANDS[1] * 569 / frames  # as many frames wide
        taken[frames] = clocked(lambda body=body, hands=hands, bands=bands: align_hands(body, hands, RATE, bands=bands))  # type: ignore[misc]
    told.add("569 frames (the paper: 10.95)", taken[569], "{:.4f}", most=0.1)
    for shorter, longer in pairwise(taken):
        told.add(f"{longer} frames over {shorter}, bands as many frames wide", taken[longer] / taken[shorter], "{:.2f}")
    return told


def clocked(work: Callable[[], object]) -> float:
    seconds = []
    for _ in range(21):
        begin = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begin)
    return float(np.median(seconds[1:]))


if __name__ == "__main__":
    run(lambda: typer.run(main))
