"""Dynamic time warping within a band, which the user's frame pairs may bend.

Majkowska, Zordan and Faloutsos 2006, 3. It takes the memory of the band: number of frames times width.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import ClipError, SettingsError
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers

MOST_CELLS = 60_000_000  # of a band: two clips of five minutes at 60 Hz, with a band of 30 %
PAIR = re.compile(r"(\d{1,9})\s*:\s*(\d{1,9})(?:\s*~\s*(\d{1,9}))?")
DIAGONAL, ALONG_BODY, ALONG_HANDS = 0, 1, 2


@dataclass(frozen=True)
class FramePair:
    """A frame of the body and the frame of the hands that belongs to it.

    Frames count from 0, in each clip as it was read.

    Attributes:
        body: The frame of the body.
        hands: The frame of the hands.
        tolerance: By how many frames of the hands the alignment may differ from `hands`.
    """

    body: int
    hands: int
    tolerance: int = 0

    @classmethod
    def parse(cls, text: str) -> FramePair:
        """Parses "BODY:HANDS" or "BODY:HANDS~TOLERANCE".

        Args:
            text: For example "120:95", or "300:288~5" with a tolerance of 5 frames.

        Returns:
            The pair.

        Raises:
            SettingsError: The text has another form.
        """
        found = PAIR.fullmatch(text.strip())
        if found is None:
            raise SettingsError("not a pair of frames", place=f"pair {text!r}", mend="Write it as 120:95 or 300:288~5")
        return cls(*(int(number or 0) for number in found.groups()))

    def __str__(self) -> str:
        return f"{self.body}:{self.hands}" + (f"~{self.tolerance}" if self.tolerance else "")


@dataclass(frozen=True, eq=False)
class Band:
    """The frames of the hands, from `low` [n] to `high` [n] inclusive, that each of n frames of the body compares with.

    width: the largest number of these frames. Costs and steps are stored in rows of this width, starting at `low`.
    """

    low: Integers
    high: Integers

    @property
    def width(self) -> int:
        return int((self.high - self.low).max()) + 1


def check_pairs(pairs: Sequence[FramePair], body_frames: int, hand_frames: int) -> list[FramePair]:
    """Returns the pairs in order of their frames.

    Raises SettingsError with the pair if a frame lies outside its clip, a tolerance is negative, or two pairs cross.
    """
    ordered = sorted(pairs, key=lambda pair: (pair.body, pair.hands))
    for pair in ordered:
        for what, frame, count in (("body", pair.body, body_frames), ("hands", pair.hands, hand_frames)):
            if not 0 <= frame < count:
                problem = f"frame {frame} of the {what} lies outside the clip, whose last frame is {count - 1}"
                raise SettingsError(problem, place=f"pair {pair}", mend="Count frames from 0")
        if pair.tolerance < 0:
            problem = f"the tolerance is {pair.tolerance} frames"
            raise SettingsError(problem, place=f"pair {pair}", mend="Use 0 or more")
    for before, after in pairwise(ordered):
        if before.body == after.body or after.hands < before.hands:
            problem = f"it crosses the pair {before}: a later frame of the body needs a later frame of the hands"
            if before.body == after.body:
                problem = f"the pair {before} has the same frame of the body"
            raise SettingsError(problem, place=f"pair {after}", mend="Remove one of the two pairs")
    return ordered


def straight_band(body_frames: int, hand_frames: int, width: float, pairs: Sequence[FramePair]) -> Band:
    """Returns the band about the straight lines from pair to pair, between the ends of the clips (equations 3 to 5).

    width: half the band's width, measured across it, as a part of the body's frames. pairs: in order. Raises ClipError
    if the band would have more than MOST_CELLS cells.
    """
    x, y, _ = anchors(body_frames, hand_frames, pairs)
    frame = np.arange(body_frames)
    centre = np.interp(frame, x, y)
    runs, rises = np.maximum(np.diff(x), 1), np.diff(y)
    reach = width * body_frames * np.hypot(runs, rises) / runs  # for each part between two pairs
    part = np.clip(np.searchsorted(x, frame, side="left") - 1, 0, len(runs) - 1)
    return band_around(centre, reach[part], body_frames, hand_frames, pairs)


def band_around(
    centre: Floats, reach: Floats | float, body_frames: int, hand_frames: int, pairs: Sequence[FramePair]
) -> Band:
    """Returns the band of frames within `reach` of a curve [n], limited by the pairs, which are in order (equation 5).

    Raises ClipError if the band would have more than MOST_CELLS cells.
    """
    least, most = limits(body_frames, hand_frames, pairs)
    # at a pair's own frame the path may still climb from the least frame that the pair before allows
    least[1:] = least[:-1].copy()
    low = np.clip(np.ceil(centre - reach), least, most).astype(np.int64)
    high = np.clip(np.floor(centre + reach), least, most).astype(np.int64)
    low, high = np.minimum(low, high), np.maximum(low, high)
    high = np.maximum.accumulate(high)
    low = np.minimum.accumulate(low[::-1])[::-1]
    # widen the band where no step leads from one row to the next
    high[:-1] = np.maximum(high[:-1], np.minimum(low[1:] - 1, most[:-1]))
    low[1:] = np.minimum(low[1:], high[:-1] + 1)
    if (cells := int(body_frames * ((high - low).max() + 1))) > MOST_CELLS:
        raise ClipError(
            f"clips of {body_frames} and {hand_frames} frames need a band of {cells:,} cells, "
            f"more than the limit of {MOST_CELLS:,}",
            mend="Use a narrower --band or shorter clips",
        )
    return Band(low, high)


def anchors(body_frames: int, hand_frames: int, pairs: Sequence[FramePair]) -> tuple[Floats, Floats, Floats]:
    """Returns body frames, hands frames and tolerances [k] of all pairs in order.

    The clips' first frames are a pair, and their last frames, unless the user's pairs hold these frames of the body.
    """
    fixed = list(pairs)
    if not fixed or fixed[0].body > 0:
        fixed.insert(0, FramePair(0, 0))
    if fixed[-1].body < body_frames - 1:
        fixed.append(FramePair(body_frames - 1, hand_frames - 1))
    if len(fixed) == 1:  # a body of one frame
        fixed *= 2
    x, y, t = np.array([(pair.body, pair.hands, pair.tolerance) for pair in fixed], np.float64).T
    return x, y, t


def limits(body_frames: int, hand_frames: int, pairs: Sequence[FramePair]) -> tuple[Floats, Floats]:
    """Returns the least and the greatest frame of the hands [n] that the pairs allow at each frame of the body.

    Neither ever decreases.
    """
    x, y, t = anchors(body_frames, hand_frames, pairs)
    frame = np.arange(body_frames)
    lowest = np.maximum.accumulate(np.maximum(y - t, 0.0))
    highest = np.minimum.accumulate(np.minimum(y + t, hand_frames - 1)[::-1])[::-1]
    return lowest[np.searchsorted(x, frame, side="right") - 1], highest[np.searchsorted(x, frame, side="left")]


@compiled(nogil=True)
def cheapest_path(costs: NDArray[np.float32], low: Integers, high: Integers) -> Integers:
    """Returns the path [steps, 2] of least cost through a band, from its first row to its last.

    costs: [n, width] of the band's cells. A step advances the body, the hands or both by one frame, and costs the cell
    that it leads to (equations 1 and 2). Of equal costs, the step that advances both wins.
    """
    count, width = costs.shape
    came = np.zeros((count, width), np.uint8)
    above, total = np.full(width, np.inf), np.full(width, np.inf)
    for i in range(count):
        above, total = total, above
        total[:] = np.inf
        for j in range(low[i], high[i] + 1):
            best, step = np.inf, DIAGONAL
            if i == 0 and j == low[0]:
                best = 0.0
            if i > 0:
                up = j - low[i - 1]
                if 0 < up <= high[i - 1] - low[i - 1] + 1:
                    best = above[up - 1]
                if up <= high[i - 1] - low[i - 1] and above[up] < best:
                    best, step = above[up], ALONG_BODY
            if j > low[i] and total[j - 1 - low[i]] < best:
                best, step = total[j - 1 - low[i]], ALONG_HANDS
            total[j - low[i]], came[i, j - low[i]] = best + costs[i, j - low[i]], step
    i, j, steps = count - 1, high[count - 1], 0
    path = np.empty((count + high[count - 1] - low[0] + 1, 2), np.int64)
    while True:
        path[steps, 0], path[steps, 1] = i, j
        steps += 1
        if i == 0 and j == low[0]:
            break
        step = came[i, j - low[i]]
        i -= 1 if step != ALONG_HANDS else 0
        j -= 1 if step != ALONG_BODY else 0
    return path[:steps][::-1].copy()


def medians(path: Integers, count: int) -> Floats:
    """Returns the median frame of the hands [count] among those that a path assigns to each frame of the body."""
    first = np.searchsorted(path[:, 0], np.arange(count), side="left")
    last = np.searchsorted(path[:, 0], np.arange(count), side="right") - 1
    return np.asarray(0.5 * (path[first, 1] + path[last, 1]))
