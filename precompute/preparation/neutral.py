"""The neutral of an action: the same gait without the action. Posture is relative to it (docs/method.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.preparation.prepared import PreparedClip

TEMPO_WEIGHT = 0.1  # metres that a tempo ratio of e adds to the distance of two gaits
FEWEST_STRIDES = 1.5  # of a neutral: less shows no mean stride


@dataclass(frozen=True, slots=True, eq=False)
class ShownGait:
    """What of a clip's gait is compared. Thousands of them are small beside their clips.

    gait: as in `PreparedClip`. tempo: cycles per second. shows_a_stride: whether its mean stride can be seen.
    """

    name: str
    gait: Floats
    tempo: float
    shows_a_stride: bool

    @classmethod
    def of(cls, clip: PreparedClip) -> ShownGait:
        cycles = clip.alignment.cycles
        shows_a_stride = clip.alignment.has_gait and (clip.period > 0 or cycles >= FEWEST_STRIDES)
        return cls(clip.name, clip.gait, cycles * clip.rate / (clip.frame_count - 1), shows_a_stride)


def nearest_gaits(actions: Sequence[ShownGait], locomotions: Sequence[ShownGait]) -> list[str]:
    """Returns for each action the name of the locomotion whose legs move most like its own.

    Compares the mean lower clouds by phase, and the tempo. Of equals, the first by name. Locomotions of less than
    FEWEST_STRIDES that are no whole cycles, or whose legs do not move as in a gait, count only if there are no others.
    """
    if not actions:
        return []
    by_name = sorted(locomotions, key=lambda one: one.name)
    usable = [one for one in by_name if one.shows_a_stride] or by_name
    theirs, tempos = np.stack([one.gait for one in usable]), np.array([one.tempo for one in usable])
    return [usable[nearest_of(theirs, tempos, one.gait, one.tempo)].name for one in actions]


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_of(gaits: Floats, tempos: Floats, gait: Floats, tempo: float) -> int:
    """Returns which of `gaits` [n, bins, 3, 3] with `tempos` [n] is nearest to a gait [bins, 3, 3] with a tempo.

    Of equals it is the first. Bins that one of the two does not have, which are NaN, do not count.
    """
    nearest, least = 0, np.inf
    for one in range(len(gaits)):
        total, common = 0.0, 0
        for k in range(gait.shape[0]):
            for point in range(gait.shape[1]):
                square = 0.0
                for axis in range(3):
                    square += (gaits[one, k, point, axis] - gait[k, point, axis]) ** 2
                if np.isfinite(square):
                    total += square
                    common += 1
        if common > 0:
            apart = np.sqrt(total / common) + TEMPO_WEIGHT * abs(np.log(tempos[one] / tempo))
            if apart < least:
                nearest, least = one, apart
    return nearest
