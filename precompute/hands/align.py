"""Time alignment of separately captured hands to a body, in two passes.

Majkowska, Zordan and Faloutsos 2006: the first pass aligns the phases of the gestures, the second the frames within
them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.errors import ClipError, SettingsError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers
from motionsplice.precompute.hands.banded_warp import (
    Band,
    FramePair,
    band_around,
    cheapest_path,
    check_pairs,
    limits,
    medians,
    straight_band,
)
from motionsplice.precompute.hands.costs import Comparison, Costs
from motionsplice.precompute.hands.points import HandMotion

BANDS = (0.3, 0.1)  # half the width of each pass's band, as a part of the body's frames
STRANGE = 0.45  # the mismatch above which hands and body hardly seem to make the same gestures
STEADYING = 0.04  # seconds: the standard deviation of the Gaussian that smooths steps of the curve
# Weights in the second pass, relative to a difference of phase: per radian between palms, and of the difference of
# paces. The paper has no pace cost; it lowers the second pass's error on real arms by a quarter (docs/hands.md).
PALM_WEIGHT, PACE_WEIGHT = 6.0, 0.6


@dataclass(frozen=True, eq=False)
class Pass:
    """One pass: its band, the costs of the band's cells [F, width] and the cheapest path through them [steps, 2]."""

    costs: Costs
    band: Band
    path: Integers


@dataclass(frozen=True, eq=False)
class HandAlignment:
    """The time alignment of hands to a body.

    frames: [F] the real-valued frame of the hands at each frame of the body; it never decreases.
    passes: the two passes that found it.
    """

    frames: Floats
    passes: tuple[Pass, Pass]

    @property
    def mismatch(self) -> float:
        """Mean phase cost along the path divided by the mean over the band.

        It is 0 for identical gestures and about 1 for unrelated ones. Two performers of the same gestures measure 0.1
        to 0.4. Above STRANGE they hardly seem to make the same gestures (docs/hands.md).
        """
        costs, band, path = self.passes[0].costs, self.passes[0].band, self.passes[0].path
        within = np.arange(band.width) <= (band.high - band.low)[:, None]
        usual = float(costs[within].mean())
        return float(costs[path[:, 0], path[:, 1] - band.low[path[:, 0]]].mean()) / usual if usual > 0.0 else 0.0


def align_hands(
    body: Sequence[HandMotion],
    hands: Sequence[HandMotion],
    rate: float,
    *,
    pairs: Sequence[FramePair] = (),
    bands: tuple[float, float] = BANDS,
    by_trunk: bool = False,
) -> HandAlignment:
    """Aligns one hand, or both together, at `rate` frames per second.

    body, hands: the same one or two hands of both clips. pairs: frames that the user wants to meet; the rest follows
    from the motion. bands: half widths of the two passes' bands, as parts of the body's frames. by_trunk: turn the
    hands onto the body's by the headings of the trunks, instead of by the best fit of the points.

    Raises SettingsError for impossible pairs, bands outside 0 to 1, or unknown trunk headings; ClipError for clips that
    are too long or whose points are too far apart to be compared.
    """
    if not all(0.0 < band <= 1.0 for band in bands):
        problem = f"bands must be above 0 and at most 1, not {bands[0]:g} and {bands[1]:g}"
        raise SettingsError(problem, mend="Use parts of the clip, such as 0.3 and 0.1")
    counts = len(body[0].points), len(hands[0].points)
    ordered = check_pairs(pairs, *counts)
    compared = [Comparison(one, other, rate, by_trunk=by_trunk) for one, other in zip(body, hands, strict=True)]
    first = _pass(straight_band(*counts, bands[0], ordered), [one.phases for one in compared])
    centre, reach = medians(first.path, counts[0]), bands[1] * np.hypot(*counts)
    within = [
        lambda band, one=one: one.phases(band) + PALM_WEIGHT * one.palms(band) + PACE_WEIGHT * one.paces(band)
        for one in compared
    ]
    second = _pass(band_around(centre, reach, *counts, ordered), within)
    frames = steadied(medians(second.path, counts[0]), STEADYING * rate)
    return HandAlignment(np.clip(frames, *limits(*counts, ordered)), (first, second))


def steadied(frames: Floats, width: float) -> Floats:
    """Smooths a curve [F] with a Gaussian whose standard deviation is `width` frames.

    A straight line stays as it is, and a rising curve stays rising.
    """
    beyond = min(int(4.0 * width) + 1, len(frames) - 1)
    longer = np.pad(frames, beyond, mode="reflect", reflect_type="odd")
    return np.asarray(gaussian_filter1d(longer, width)[beyond : beyond + len(frames)])


def _pass(band: Band, costs_of: Sequence[Callable[[Band], Costs]]) -> Pass:
    """Finds the cheapest path through a band by the sum of the costs. Raises ClipError if a cost is not finite."""
    costs = np.sum([one(band) for one in costs_of], axis=0)
    if not np.isfinite(costs).all():
        raise ClipError("the hands move too far to be compared", mend="Check the unit of length of both clips")
    return Pass(costs, band, cheapest_path(costs, band.low, band.high))
