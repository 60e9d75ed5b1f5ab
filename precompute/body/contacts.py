"""Foot contacts, found from how low and how slow ankles and toes are."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.joint_paths import joint_paths
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT

SLOW = 0.55  # leg lengths per second: the fastest a standing joint may move, as captured feet roll, slide and jitter
SLOW_OF_FAST = 0.15  # or this part of the joint's 95th percentile speed: in a run the feet hardly rest
LOW = 0.09  # leg lengths that a standing joint may be above its lowest point within STEP
STEP = 0.5  # seconds: less than a foot takes from one stair to the next
SMOOTHED, SHORTEST = 0.05, 0.06  # seconds: the window that smooths speeds; the shortest contact, and gap in a contact
LOADING = 0.1  # seconds in which a foot takes over the weight, and gives it up
BITS = np.array([LEFT_FOOT, RIGHT_FOOT], np.uint8)


def foot_contacts(clip: Clip, roles: Roles) -> NDArray[np.uint8]:
    """Returns which feet stand at each frame [F]: the bits LEFT_FOOT and RIGHT_FOOT, or 0."""
    (left, right), rate, leg = roles.feet, clip.rate, roles.leg_length(clip.skeleton)
    paths = joint_paths(clip, (*left, *right))
    speeds, above = speeds_and_heights(paths, 1.0 / rate, _frames(SMOOTHED, rate), _frames(STEP, rate))
    slow = np.maximum(SLOW * leg, SLOW_OF_FAST * _fast(speeds))
    return np.asarray(_lasting(feet_down(speeds, above, slow, LOW * leg, len(left)), rate) @ BITS)


def support(standing: NDArray[np.uint8], rate: float) -> Floats:
    """Returns how firmly both feet stand [F, 2], 0 to 1, from the bits of standing feet [F]; smooth over LOADING."""
    return smoothed_bits(standing, BITS, _loading(rate))


@lru_cache(maxsize=4)
def _loading(rate: float) -> Floats:
    """Returns the weights of successive frames by which a foot takes over the weight."""
    window = np.hanning(2 * round(0.5 * LOADING * rate) + 3)[1:-1]
    return np.asarray(window / window.sum())


@compiled(nogil=True, error_model="numpy")
def smoothed_bits(standing: NDArray[np.uint8], bits: NDArray[np.uint8], window: Floats) -> Floats:
    """Returns means [F, n] of whether each of `bits` [n] is set in `standing` [F], weighted by a symmetric `window`.

    The first and the last frame are repeated beyond the ends. As SciPy's `convolve1d`, to the last bit.
    """
    last, half = len(standing) - 1, len(window) // 2
    means = np.empty((len(standing), len(bits)))
    for i in range(len(standing)):
        for n in range(len(bits)):
            total = window[half] if standing[i] & bits[n] else 0.0
            for k in range(half, 0, -1):
                count = 1.0 if standing[max(i - k, 0)] & bits[n] else 0.0
                count += 1.0 if standing[min(i + k, last)] & bits[n] else 0.0
                total += count * window[half + k]
            means[i, n] = total
    return means


def left_strike(standing: NDArray[np.uint8], rate: float, first: float, last: float) -> float | None:
    """Returns when the left foot first touches down between `first` and `last`, seconds; None if it does not.

    standing: [F] of `foot_contacts`.
    """
    stands = (standing & LEFT_FOOT).astype(np.int8)
    downs = (np.flatnonzero(np.diff(stands) > 0) + 0.5) / rate
    return next((float(down) for down in downs if first <= down < last), None)


@compiled(nogil=True)
def feet_down(speeds: Floats, above: Floats, slow: Floats, low: float, left: int) -> NDArray[np.uint8]:
    """Returns which feet stand [F, 2], 0 or 1: those of which a joint is slow and low.

    speeds, above: [F, n] of `speeds_and_heights`; the first `left` joints are those of the left foot. slow: [n].
    """
    feet = np.zeros((len(speeds), 2), np.uint8)
    for i in range(len(speeds)):
        for joint in range(speeds.shape[1]):
            if speeds[i, joint] < slow[joint] and above[i, joint] < low:
                feet[i, 0 if joint < left else 1] = 1
    return feet


def _fast(speed: Floats) -> Floats:
    """Returns the 95th percentile [n] of speeds [F, n], as `np.percentile`, which takes several times as long."""
    place = 0.95 * (len(speed) - 1)
    before = int(place)
    after, part = min(before + 1, len(speed) - 1), place - before
    ordered = np.partition(speed, (before, after), axis=0)
    low, high = ordered[before], ordered[after]
    return np.asarray(low + (high - low) * part if part < 0.5 else high - (high - low) * (1.0 - part))


@compiled(nogil=True, error_model="numpy")
def speeds_and_heights(paths: Floats, step: float, smoothed: int, reach: int) -> tuple[Floats, Floats]:
    """Returns the smoothed speeds of joints [F, n], and how far they are above their lowest point nearby [F, n].

    paths: [F, n, 3] metres, `step` seconds apart, F of two or more. smoothed, reach: odd numbers of frames, over which
    speeds are averaged and the lowest point is sought; the first and the last frame are repeated beyond the ends.
    """
    count, joints = len(paths), paths.shape[1]
    last = count - 1
    speeds, above, raw = np.empty((count, joints)), np.empty((count, joints)), np.empty(count)
    for joint in range(joints):
        for i in range(count):
            before, after = max(i - 1, 0), min(i + 1, last)
            seconds = 2.0 * step if after - before == 2 else step
            x = (paths[after, joint, 0] - paths[before, joint, 0]) / seconds
            y = (paths[after, joint, 1] - paths[before, joint, 1]) / seconds
            z = (paths[after, joint, 2] - paths[before, joint, 2]) / seconds
            raw[i] = np.sqrt(x * x + y * y + z * z)
        half, total = smoothed // 2, 0.0
        for i in range(-half, half + 1):
            total += raw[min(max(i, 0), last)]
        speeds[0, joint] = total / smoothed
        for i in range(1, count):
            total += raw[min(i + half, last)] - raw[max(i - 1 - half, 0)]
            speeds[i, joint] = total / smoothed
        half, lowest = reach // 2, -reach  # lowest: the frame of the lowest point in reach, none yet
        for i in range(count):
            if lowest < i - half:
                lowest = max(i - half, 0)
                for k in range(lowest + 1, min(i + half, last) + 1):
                    lowest = k if paths[k, joint, 1] <= paths[lowest, joint, 1] else lowest
            elif i + half <= last and paths[i + half, joint, 1] <= paths[lowest, joint, 1]:
                lowest = i + half
            above[i, joint] = paths[i, joint, 1] - paths[lowest, joint, 1]
    return speeds, above


def _lasting(feet: NDArray[np.uint8], rate: float) -> NDArray[np.uint8]:
    """Returns which feet stand [F, 2], 0 or 1, without gaps in a contact, and then contacts, below SHORTEST.

    Of a contact that the clip begins or ends in, half is enough.
    """
    lasting, shortest = feet.copy(), _frames(SHORTEST, rate)
    invert_short(lasting, 0, shortest, 0)
    invert_short(lasting, 1, shortest, shortest // 2)
    return lasting


@compiled(nogil=True)
def invert_short(feet: NDArray[np.uint8], value: int, shortest: int, at_ends: int) -> None:
    """Inverts runs of a value, 0 or 1, in each column of `feet` [F, n] that are below `shortest` frames.

    at_ends: the least length of a first or a last run.
    """
    count = len(feet)
    for foot in range(feet.shape[1]):
        begin = 0
        for i in range(1, count + 1):
            if i == count or feet[i, foot] != feet[i - 1, foot]:
                inside = begin > 0 and i < count
                if feet[i - 1, foot] == value and i - begin < min(count, shortest if inside else at_ends):
                    feet[begin:i, foot] = 1 - value
                begin = i


def _frames(seconds: float, rate: float) -> int:
    """Returns a duration as an odd number of frames, at least 3."""
    return 2 * max(round(0.5 * seconds * rate), 1) + 1
