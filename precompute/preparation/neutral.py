"""The neutral of an action: the same gait without the action. Posture is relative to it (docs/method.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.preparation.prepared import PreparedClip

TEMPO_WEIGHT = 0.1  # metres that a tempo ratio of e adds to the distance of two gaits
AT_ONCE = 256  # gaits that are compared with as many others, while both are in a core's cache
ROUNDING = 1e-9  # metres; rounding changes distances by less
FEWEST_STRIDES = 1.5  # of a neutral: less shows no mean stride


@dataclass(frozen=True, slots=True, eq=False)
class ShownGait:
    """The part of a clip's gait that is compared. It is small, as a job keeps that of all clips.

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
    theirs, tempos = np.stack([one.gait for one in usable], axis=-1), np.array([one.tempo for one in usable])
    seen, nearest = np.asarray(np.isfinite(theirs).all(axis=2), np.float64), list[int]()
    theirs[~np.isfinite(theirs)] = 0.0
    for first in range(0, len(actions), AT_ONCE):
        some = actions[first : first + AT_ONCE]
        ours, our_tempos = np.stack([one.gait for one in some]), np.array([one.tempo for one in some])
        nearest += nearest_of(theirs, seen, tempos, ours, our_tempos).tolist()
    return [usable[one].name for one in nearest]


@compiled(nogil=True, error_model="numpy")
def nearest_of(theirs: Floats, seen: Floats, tempos: Floats, ours: Floats, our_tempos: Floats) -> NDArray[np.int64]:
    """Returns [m] which of `theirs` [bins, 3, 3, n] is nearest to each of `ours` [m, bins, 3, 3]. Of equals the first.

    seen: [bins, 3, n] 1 where one of theirs has a point, else 0; its coordinates are then 0. Points that one of ours
    does not have are NaN. Points that one of the two does not have do not count.
    """
    nearest, least = np.zeros(len(ours), np.int64), np.full(len(ours), np.inf)
    for first in range(0, len(tempos), AT_ONCE):
        size = min(AT_ONCE, len(tempos) - first)
        total, common = np.empty(size), np.empty(size)
        for mine in range(len(ours)):
            _add_squares(theirs, seen, first, ours[mine], total, common)
            for one in range(size):
                enough = common[one] * (least[mine] + ROUNDING) ** 2 if common[one] > 0.0 else 0.0
                if total[one] < enough:  # else it is farther, whatever its tempo
                    apart = np.sqrt(total[one] / common[one])
                    apart += TEMPO_WEIGHT * abs(np.log(tempos[first + one] / our_tempos[mine]))
                    if apart < least[mine]:
                        nearest[mine], least[mine] = first + one, apart
    return nearest


@compiled(nogil=True, error_model="numpy")
def _add_squares(theirs: Floats, seen: Floats, first: int, ours: Floats, total: Floats, common: Floats) -> None:
    """Sets the sums of squared distances of points and the numbers of points, of as many of theirs as `total` is long.

    The inner loop takes several of theirs in one instruction.
    """
    size = len(total)
    total[:], common[:] = 0.0, 0.0
    for k in range(ours.shape[0]):
        for point in range(ours.shape[1]):
            x, y, z = ours[k, point, 0], ours[k, point, 1], ours[k, point, 2]
            if np.isfinite(x + y + z):
                xs, ys = theirs[k, point, 0][first : first + size], theirs[k, point, 1][first : first + size]
                zs, counts = theirs[k, point, 2][first : first + size], seen[k, point][first : first + size]
                for one in range(size):
                    total[one] += counts[one] * ((xs[one] - x) ** 2 + (ys[one] - y) ** 2 + (zs[one] - z) ** 2)
                for one in range(size):  # a loop of its own, as compilers vectorise few arrays at once
                    common[one] += counts[one]
