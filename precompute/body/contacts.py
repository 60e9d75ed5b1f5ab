"""Foot contacts, found from how low and how slow ankles and toes are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d, maximum_filter1d, minimum_filter1d, uniform_filter1d

from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.joint_paths import joint_paths
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT, which_stand

SLOW = 0.55  # leg lengths per second: the fastest a standing joint may move, as captured feet roll, slide and jitter
SLOW_OF_FAST = 0.15  # or this part of the joint's 95th percentile speed: in a run the feet hardly rest
LOW = 0.09  # leg lengths that a standing joint may be above its lowest point within STEP
STEP = 0.5  # seconds: less than a foot takes from one stair to the next
SMOOTHED, SHORTEST = 0.05, 0.06  # seconds: the window that smooths speeds; the shortest contact, and gap in a contact
LOADING = 0.1  # seconds in which a foot takes over the weight, and gives it up


def foot_contacts(clip: Clip, roles: Roles) -> NDArray[np.uint8]:
    """Returns which feet stand at each frame [F]: the bits LEFT_FOOT and RIGHT_FOOT, or 0."""
    left, right = roles.feet
    standing = _standing_joints(joint_paths(clip, (*left, *right)), clip.rate, roles.leg_length(clip.skeleton))
    feet = np.stack([standing[:, : len(left)].any(axis=1), standing[:, len(left) :].any(axis=1)], axis=1)
    return np.asarray(_lasting(feet.astype(np.uint8), clip.rate) @ np.array([LEFT_FOOT, RIGHT_FOOT], np.uint8))


def support(standing: NDArray[np.uint8], rate: float) -> Floats:
    """Returns how firmly both feet stand [F, 2], 0 to 1, from the bits of standing feet [F]; smooth over LOADING."""
    window = np.hanning(2 * round(0.5 * LOADING * rate) + 3)[1:-1]
    return np.asarray(
        convolve1d(which_stand(standing).astype(np.float64), window / window.sum(), axis=0, mode="nearest")
    )


def left_strike(standing: NDArray[np.uint8], rate: float, first: float, last: float) -> float | None:
    """Returns when the left foot first touches down between `first` and `last`, seconds; None if it does not.

    standing: [F] of `foot_contacts`.
    """
    stands = (standing & LEFT_FOOT).astype(np.int8)
    downs = (np.flatnonzero(np.diff(stands) > 0) + 0.5) / rate
    return next((float(down) for down in downs if first <= down < last), None)


def _standing_joints(paths: Floats, rate: float, leg: float) -> NDArray[np.bool_]:
    """Returns at which frames each joint of the feet stands [F, n]; `paths` [F, n, 3] in metres, `leg` its length."""
    speed = np.linalg.norm(np.gradient(paths, 1.0 / rate, axis=0), axis=-1)
    speed = uniform_filter1d(speed, _frames(SMOOTHED, rate), axis=0, mode="nearest")
    height = paths[..., 1] - minimum_filter1d(paths[..., 1], _frames(STEP, rate), axis=0, mode="nearest")
    slow = np.maximum(SLOW * leg, SLOW_OF_FAST * np.percentile(speed, 95.0, axis=0))
    return np.asarray((speed < slow) & (height < LOW * leg))


def _lasting(feet: NDArray[np.uint8], rate: float) -> NDArray[np.uint8]:
    """Returns which feet stand [F, 2], 0 or 1, without gaps in a contact, and then contacts, below SHORTEST."""
    brief = _frames(SHORTEST, rate)
    stands = np.pad(feet, ((brief, brief), (0, 0)), mode="edge")
    for widen in (maximum_filter1d, minimum_filter1d, minimum_filter1d, maximum_filter1d):
        stands = widen(stands, brief, axis=0, mode="constant")
    return stands[brief:-brief]


def _frames(seconds: float, rate: float) -> int:
    """Returns a duration as an odd number of frames, at least 3."""
    return 2 * max(round(0.5 * seconds * rate), 1) + 1
