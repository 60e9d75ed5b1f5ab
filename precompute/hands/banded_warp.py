"""Dynamic time warping within a band, which a user's pairs of frames may bend.

Majkowska, Zordan and Faloutsos 2006, 3. Memory is that of the band: frames x its width.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motionsplice.motion.errors import ClipError, SettingsError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers

MOST_CELLS = 60_000_000  # of a band: five minutes against five at 60 Hz with a width of 30 %
PAIR = re.compile(r"(\d{1,9})\s*:\s*(\d{1,9})(?:\s*~\s*(\d{1,9}))?")
DIAGONAL, ALONG_BODY, ALONG_HANDS = 0, 1, 2


@dataclass(frozen=True)
class FramePair:
    """Frames of body and hands that go together, give or take `tolerance` frames of the hands."""

    body: int
    hands: int
    tolerance: int = 0

    @classmethod
    def parse(cls, text: str) -> FramePair:
        """From "120:95", or "300:288~5" with a tolerance. Raises SettingsError."""
        found = PAIR.fullmatch(text.strip())
        if found is None:
            raise SettingsError("it is no pair of frames", place=f"pair {text!r}", mend="Write 120:95 or 300:288~5")
        return cls(*(int(number or 0) for number in found.groups()))

    def __str__(self) -> str:
        return f"{self.body}:{self.hands}" + (f"~{self.tolerance}" if self.tolerance else "")


@dataclass(frozen=True, eq=False)
class Band:
    """The frames of the hands, `low` to `high` [n] with both, that each of n frames of the body is compared with.

    width: how many these are at most. Costs and steps are kept in rows of that width, from `low` on.
    """

    low: Integers
    high: Integers

    @property
    def width(self) -> int:
        return int((self.high - self.low).max()) + 1


def check_pairs(pairs: Sequence[FramePair], body_frames: int, hand_frames: int) -> list[FramePair]:
    """The pairs in order. Raises SettingsError, naming the pair, if one lies outside the clips or two are crossed."""
    ordered = sorted(pairs, key=lambda pair: (pair.body, pair.hands))
    for pair in ordered:
        for what, frame, count in (("body", pair.body, body_frames), ("hands", pair.hands, hand_frames)):
            if not 0 <= frame < count:
                problem = f"frame {frame} of the {what} lies outside the clip, whose last is {count - 1}"
                raise SettingsError(problem, place=f"pair {pair}", mend="Count frames from 0")
        if pair.tolerance < 0:
            raise SettingsError("a tolerance is at least 0 frames", place=f"pair {pair}")
    for before, after in pairwise(ordered):
        if before.body == after.body or after.hands < before.hands:
            problem = f"it is crossed by the pair {before}: later frames of the body need later frames of the hands"
            if before.body == after.body:
                problem = f"the pair {before} has the same frame of the body"
            raise SettingsError(problem, place=f"pair {after}", mend="Leave one of them out")
    return ordered


def straight_band(body_frames: int, hand_frames: int, width: float, pairs: Sequence[FramePair]) -> Band:
    """The band about the straight lines from pair to pair (equations 3 to 5), whose ends are the clips' ends.

    width: half the band's, across it, as a part of the body's frames; pairs in order. Raises ClipError for clips whose
    band would have more than MOST_CELLS.
    """
    x, y, _ = anchors(body_frames, hand_frames, pairs)
    frame = np.arange(body_frames)
    centre = np.interp(frame, x, y)
    runs, rises = np.maximum(np.diff(x), 1), np.diff(y)
    reach = width * body_frames * np.hypot(runs, rises) / runs  # of each part between two pairs
    part = np.clip(np.searchsorted(x, frame, side="left") - 1, 0, len(runs) - 1)
    return band_around(centre, reach[part], body_frames, hand_frames, pairs)


def band_around(
    centre: Floats, reach: Floats | float, body_frames: int, hand_frames: int, pairs: Sequence[FramePair]
) -> Band:
    """The band of frames within `reach` of a curve [n], as far as pairs in order allow (equation 5)."""
    least, most = limits(body_frames, hand_frames, pairs)
    # up to a pair's own frame the path may climb from where the pair before has left it
    least[1:] = least[:-1].copy()
    low = np.clip(np.ceil(centre - reach), least, most).astype(np.int64)
    high = np.clip(np.floor(centre + reach), least, most).astype(np.int64)
    low, high = np.minimum(low, high), np.maximum(low, high)
    high = np.maximum.accumulate(high)
    low = np.minimum.accumulate(low[::-1])[::-1]
    # so that a step leads from row to row
    high[:-1] = np.maximum(high[:-1], np.minimum(low[1:] - 1, most[:-1]))
    low[1:] = np.minimum(low[1:], high[:-1] + 1)
    if (cells := int(body_frames * ((high - low).max() + 1))) > MOST_CELLS:
        raise ClipError(
            f"clips of {body_frames} and {hand_frames} frames are too long for a band of {cells:,} cells, "
            f"of which there may be {MOST_CELLS:,}",
            mend="Give a narrower --band, or shorter clips",
        )
    return Band(low, high)


def anchors(body_frames: int, hand_frames: int, pairs: Sequence[FramePair]) -> tuple[Floats, Floats, Floats]:
    """The frames [k] of body and hands of all pairs in order, and their tolerances; ends go with ends unless given."""
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
    """The least and the most frame of the hands [n] that pairs allow each frame of the body, both of them rising."""
    x, y, t = anchors(body_frames, hand_frames, pairs)
    frame = np.arange(body_frames)
    lowest = np.maximum.accumulate(np.maximum(y - t, 0.0))
    highest = np.minimum.accumulate(np.minimum(y + t, hand_frames - 1)[::-1])[::-1]
    return lowest[np.searchsorted(x, frame, side="right") - 1], highest[np.searchsorted(x, frame, side="left")]


@njit(cache=True, nogil=True)
def cheapest_path(costs: NDArray[np.float32], low: Integers, high: Integers) -> Integers:
    """The path [steps, 2] of least cost through a band, from its first row to its last.

    costs [n, width]: of each cell of the band. A step goes on by one frame of the body, of the hands or of both, and
    costs what the cell does to which it leads (equations 1 and 2); of equals the one of both is taken.
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
    """Of all frames of the hands that a path gives to each of `count` frames of the body, the one in the middle [n]."""
    first = np.searchsorted(path[:, 0], np.arange(count), side="left")
    last = np.searchsorted(path[:, 0], np.arange(count), side="right") - 1
    return np.asarray(0.5 * (path[first, 1] + path[last, 1]))
