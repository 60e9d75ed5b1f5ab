"""Makes an action without a gait ready to be laid on locomotions: its stance, and how it departs from it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.parts import MASKS, PART_NAMES, PARTS, UPPER_BODY
from motionsplice.motion.roles import Roles
from motionsplice.precompute.preparation.cuts import Cut
from motionsplice.precompute.preparation.stance import Stance, departures, parts_used, rest_frames
from motionsplice.runtime.format.standing import Standing

NO_REST = "has no frames at rest at its ends, so it poses the whole upper body: name an idle as its neutral"
UNUSED = "no part of it departs from its stance, so it shows nothing: name an idle as its neutral, or set its mask"

TRIMS = (0.0, 0.25, 0.5, 0.75, 1.0)  # seconds after a stop and before a start: the first with rest between counts


@dataclass(frozen=True, eq=False)
class Measured:
    """A standing action's departures at all its rows, the names of the parts it uses, and what the user should know."""

    standing: Standing
    uses: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def note(self) -> str:
        """A sentence that says what kind of clip this is."""
        return f"stands, so it plays at its own speed; it uses {', '.join(self.uses) or 'nothing'}"


def measure_standing(
    clip: Clip, frame_count: int, idle: Clip | None, mask: str | None, roles: Roles, cut: Cut | None = None
) -> Measured:
    """Measures a standing action.

    Args:
        clip: Its own frames, then those of its seam.
        frame_count: Number of its own frames.
        idle: A clip that shows its stance; None for the frames at rest of the clip itself.
        mask: The parts that it poses alone at all its frames; None to measure them.
        roles: Which joint is which.
        cut: The stretch of a hybrid clip that it is, or None.
    """
    rest = rest_frames(clip.frames(0, frame_count), roles) if cut is None else _rest_within(clip, cut, roles)
    shown, frames = (clip, rest) if idle is None else (idle, np.arange(idle.frame_count))
    at_rest = len(frames) > 0
    stance = Stance.of(shown, frames if at_rest else np.arange(frame_count), roles)
    standing = departures(clip, stance, roles, rest)
    if mask is not None or not at_rest:
        standing = _posing(standing, UPPER_BODY if mask is None else MASKS[mask])
        uses = tuple(name for number, name in enumerate(PART_NAMES) if standing.parts >> number & 1)
        return Measured(standing, uses, () if at_rest else (NO_REST,))
    uses = parts_used(clip, standing, roles, slice(None) if cut is None else cut.settled(clip.rate))
    return Measured(standing, uses, () if uses else (UNUSED,))


def _rest_within(clip: Clip, cut: Cut, roles: Roles) -> NDArray[np.int64]:
    """Returns the frames at rest near the ends of a stretch, once a person who stops or starts stands still."""
    first, last = int(np.ceil(cut.enters)), int(cut.leaves)
    for trim in (np.array(TRIMS) * clip.rate).astype(np.int64).tolist():
        if first + trim < last - trim:
            rest = rest_frames(clip.frames(first + trim, last - trim + 1), roles)
            if len(rest):
                return first + trim + rest
    return np.zeros(0, np.int64)


def _posing(standing: Standing, parts: int) -> Standing:
    """Returns departures of an action that poses these parts alone, and drives no others."""
    given = [float(parts >> number & 1) for number in range(PARTS)]
    return replace(standing, usage=np.tile(given, (len(standing.turns), 1)), parts=parts)
