"""How each character of a scene plays its locomotion."""

from __future__ import annotations

import numpy as np

from runtime.compiled import Array, kernel
from runtime.requests import REQUEST

PLAYBACK = np.dtype(
    [
        ("id", np.uint32),
        ("cycles", np.int32),  # how many cycles the locomotion goes back from its end
        ("speed", np.float64),
        ("end", np.float64),  # of the locomotion, seconds
        ("back", np.float64),  # where it goes on from there, seconds
        ("loop", np.bool_),
        ("held", np.bool_),  # it holds its end
    ],
    align=True,
)


@kernel
def advance(requests: Array, playback: Array, seconds: float) -> bool:
    """Moves all characters on in time, and says whether one of them is past its end."""
    over = False
    for row in range(len(requests)):
        time = requests[row]["time"] + playback[row]["speed"] * seconds
        requests[row]["time"] = time
        over |= time > playback[row]["end"]
    return over


def warm() -> None:
    """Compiles the kernel, or loads it compiled."""
    advance(np.zeros(1, REQUEST), np.zeros(1, PLAYBACK), 0.0)
