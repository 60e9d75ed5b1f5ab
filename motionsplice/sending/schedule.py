"""A steady rate: frames that are due at fixed times after the first, however long each takes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from motionsplice.motion.errors import SettingsError

LEAST, MOST = 1.0, 240.0  # frames per second
ROUNDING = 1e-6  # of a frame


class Schedule:
    """Yields the numbers of frames when they are due.

    A frame that is late by a whole frame or more is left out, so that frames never come in bursts. The last frame is
    never left out.

    Args:
        rate: Frames per second.
        seconds: Time from the first frame to the last; None for no end.
        clock: Returns the time in seconds.
        sleep: Waits for some seconds.

    Attributes:
        made: Number of frames yielded so far.
        left_out: Number of frames left out so far.
        late: Sum of seconds by which frames came late.
        latest: The largest of them.

    Raises:
        SettingsError: The rate is not from 1 to 240.
    """

    def __init__(
        self,
        rate: float,
        seconds: float | None = None,
        *,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if not LEAST <= rate <= MOST:
            raise SettingsError(f"the rate is {rate:g} frames per second", mend=f"Give {LEAST:g} to {MOST:g}")
        self.rate = rate
        self._frames = None if seconds is None else int(seconds * rate + ROUNDING) + 1
        self._clock, self._sleep = clock, sleep
        self.made = self.left_out = 0
        self.late = self.latest = 0.0

    def __iter__(self) -> Iterator[int]:
        start, number = self._clock(), 0
        while self._frames is None or number < self._frames:
            wait = start + number / self.rate - self._clock()
            if wait > 0.0:
                self._sleep(wait)
            newest = int((self._clock() - start) * self.rate)
            if self._frames is not None:
                newest = min(newest, self._frames - 1)
            if newest > number:
                self.left_out += newest - number
                number = newest
            lateness = max(self._clock() - start - number / self.rate, 0.0)
            self.made += 1
            self.late += lateness
            self.latest = max(self.latest, lateness)
            yield number
            number += 1
