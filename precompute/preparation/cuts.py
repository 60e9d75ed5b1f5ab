"""Where a hybrid clip is cut: each stretch becomes a clip of its own, with frames before and after that are blended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motionsplice.precompute.alignment.stretches import Stretch

LEAD = 0.6  # seconds before a walking stretch: more than the part of a stride by which it may begin earlier
SETTLING = 0.5  # seconds in which a person stops or starts
TAIL = 0.6  # seconds after a stretch: it goes on while the next fades in


@dataclass(frozen=True)
class Cut:
    """The frames of a clip from `begin` to `end` - 1, which take over at `enters` and hand over at `leaves`.

    These two are real-valued frames, counted from `begin`. number: of the stretch, from 1 on.
    """

    number: int
    begin: int
    end: int
    enters: float
    leaves: float

    def settled(self, rate: float) -> slice:
        """Returns the frames, counted from `begin`, that are not about a stop or a start."""
        most = 0.25 * (self.leaves - self.enters)
        first = 0.0 if self.begin == 0 else self.enters + min(SETTLING * rate, most)
        last = self.leaves if self.end - self.begin - 1 == self.leaves else self.leaves - min(SETTLING * rate, most)
        return slice(int(np.ceil(first)), int(last) + 1)


def cuts(stretches: Sequence[Stretch], rate: float, frame_count: int) -> tuple[Cut, ...]:
    """Returns how a clip of so many frames per second is cut into its stretches."""
    found = []
    for number, one in enumerate(stretches, 1):
        lead = 0.0 if one.stands else LEAD
        begin = max(int(np.floor((one.begin - lead) * rate)), 0)
        end = min(int(np.ceil((one.end + TAIL) * rate)) + 1, frame_count)
        last = frame_count - 1.0 if number == len(stretches) else one.end * rate
        found.append(Cut(number, begin, end, one.begin * rate - begin, last - begin))
    return tuple(found)
