"""Clips at the rate at which motions are compared."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.contacts import foot_contacts, support
from motionsplice.precompute.body.joint_paths import joint_paths

WORKING_RATE = 30.0  # frames per second at which motions are compared


def paths_at_working_rate(clip: Clip, joints: tuple[int, ...]) -> Floats:
    """Returns world positions [n, p, 3] of p joints at about the working rate, from the first frame to the last."""
    positions, at = joint_paths(clip, joints), _working_frames(clip)
    before = np.minimum(at.astype(np.int64), clip.frame_count - 2)
    t = (at - before)[:, None, None]
    return np.asarray((1.0 - t) * positions[before] + t * positions[before + 1])


def support_at_working_rate(clip: Clip, roles: Roles) -> Floats:
    """Returns how firmly both feet stand [n, 2], 0 to 1, at the moments of `paths_at_working_rate`."""
    firm = support(foot_contacts(clip, roles), clip.rate)
    return np.stack([np.interp(_working_frames(clip), np.arange(clip.frame_count), foot) for foot in firm.T], axis=1)


def level(clouds: Floats) -> Floats:
    """Returns clouds [n, p, 3] about their mean height, so that steps on a stair compare with steps on the floor.

    The papers shift clouds over the floor only. Up a stair of three steps this leaves the legs 40 cm from the
    baseline's; levelling leaves 4 cm. On level ground the difference is negligible.
    """
    return clouds - clouds.mean(axis=1, keepdims=True) * np.array([0.0, 1.0, 0.0])


def _working_frames(clip: Clip) -> Floats:
    return np.linspace(0.0, clip.frame_count - 1, max(2, round(clip.duration * WORKING_RATE) + 1))
