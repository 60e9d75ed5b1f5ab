"""Clips at the rate at which motions are compared."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.body.contacts import support
from motionsplice.precompute.body.joint_paths import joint_paths
from motionsplice.precompute.body.sampled_rows import sampled_rows

WORKING_RATE = 30.0  # frames per second at which motions are compared


def paths_at_working_rate(clip: Clip, joints: tuple[int, ...]) -> Floats:
    """Returns world positions [n, p, 3] of p joints at about the working rate, from the first frame to the last."""
    return sampled_rows(joint_paths(clip, joints), _working_frames(clip.frame_count, clip.rate))


def support_at_working_rate(clip: Clip, standing: NDArray[np.uint8]) -> Floats:
    """Returns how firmly both feet stand [n, 2], 0 to 1, at the moments of `paths_at_working_rate`.

    standing: [F] of `foot_contacts`.
    """
    return sampled_rows(support(standing, clip.rate), _working_frames(clip.frame_count, clip.rate))


@lru_cache(maxsize=4)  # the alignment of a clip asks several times
def _working_frames(frame_count: int, rate: float) -> Floats:
    duration = (frame_count - 1) / rate
    return np.linspace(0.0, frame_count - 1, max(2, round(duration * WORKING_RATE) + 1))
