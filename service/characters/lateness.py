"""Which frames are left out when the clock is late: as many for one connection as for another."""

from __future__ import annotations

import math

BEHIND = 0.1  # seconds by which the clock may be late for once before frames are left out
LEFT_OUT = 1.0  # seconds by which characters move on at most when frames are left out
FEW = 20_000  # characters times frames that are advanced within a few milliseconds
LONGEST_STEP = 0.1  # seconds by which characters are advanced at once
IN_A_TURN = 4  # frames by which characters move on in a turn while the clock is on time: about half a millisecond


class Lateness:
    """The lateness of a clock that makes frames of many connections.

    A clock that is late for once makes up for it by frames in quick succession. Once it is more than BEHIND late, there
    is more work than time. Until it is on time again, each connection then gets its newest frame whenever all others
    have theirs.

    Attributes:
        sheds: Whether only newest frames are made.
    """

    def __init__(self) -> None:
        self.sheds = False

    def begin(self, late: float) -> None:
        """Begins to make frames, the first of which was due `late` seconds ago."""
        if late > BEHIND:
            self.sheds = True

    def end(self) -> None:
        """Notes that no frame is due."""
        self.sheds = False

    def missed(self, due: float, rate: float, now: float) -> int:
        """Returns how many frames of a connection to leave out, whose next frame was due at `due`."""
        late = now - due
        return math.floor(late * rate) if late > (0.0 if self.sheds else BEHIND) else 0


def moved(missed: int, rate: float) -> int:
    """Returns by how many frames characters move on that miss frames."""
    return min(missed, math.ceil(LEFT_OUT * rate))


def frames_at_once(work: int, rate: float) -> int:
    """Returns by how many frames to advance at once, for `work` characters times frames of all connections."""
    return 1 if work <= FEW else math.ceil(LONGEST_STEP * rate)
