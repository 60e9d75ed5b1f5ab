"""Which frame of a separately captured hand goes with which frame of a body: alignment in two passes.

Majkowska, Zordan and Faloutsos 2006: the phases of the gestures are aligned first, then frames within them.
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

BANDS = (0.3, 0.1)  # of the body's frames: half the width of each pass's band
STRANGE = 0.45  # a mismatch above which hands and body do not seem to make the same gestures
STEADYING = 0.04  # seconds: the standard deviation of the bell that steps of the curve are blended with
# what they weigh beside a difference of phase in the second pass: a radian between palms, and the difference of paces,
# which the paper has not: with it the second pass errs by a quarter less on real arms (docs/hands.md)
PALM_WEIGHT, PACE_WEIGHT = 6.0, 0.6


@dataclass(frozen=True, eq=False)
class Pass:
    """One pass: its costs in the cells of a band [F, width], and the cheapest path [steps, 2] through them."""

    costs: Costs
    band: Band
    path: Integers


@dataclass(frozen=True, eq=False)
class HandAlignment:
    """frames: [F] which real-valued frame of the hands goes with each frame of the body; it never falls."""

    frames: Floats
    passes: tuple[Pass, Pass]

    @property
    def mismatch(self) -> float:
        """By how much phases of frames that go together differ, as a part of what those of all in the band do.

        0.1 to 0.4 where both performers do the same gestures; above STRANGE they hardly do (docs/hands.md).
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

    body, hands: the same hands of both clips. pairs: frames that a user wants to go together; the rest follows from the
    motion. by_trunk: hands are turned as the trunks are, and not as suits their points best. Raises SettingsError for
    pairs that cannot be, bands that are none, or trunks that are not known; ClipError for clips that are too long or
    move without bounds.
    """
    if not all(0.0 < band <= 1.0 for band in bands):
        problem = f"bands of {bands[0]:g} and {bands[1]:g} of the clip mean nothing"
        raise SettingsError(problem, mend="Give parts of 1, such as 0.3 and 0.1")
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
    """A curve [F] blended by a bell of so many frames, which leaves a line, and what rises, as they are."""
    beyond = min(int(4.0 * width) + 1, len(frames) - 1)
    longer = np.pad(frames, beyond, mode="reflect", reflect_type="odd")
    return np.asarray(gaussian_filter1d(longer, width)[beyond : beyond + len(frames)])


def _pass(band: Band, costs_of: Sequence[Callable[[Band], Costs]]) -> Pass:
    """The cheapest path by the sum of costs."""
    costs = np.sum([one(band) for one in costs_of], axis=0)
    if not np.isfinite(costs).all():
        raise ClipError("its hands move too far to be compared", mend="Check its unit of length")
    return Pass(costs, band, cheapest_path(costs, band.low, band.high))
