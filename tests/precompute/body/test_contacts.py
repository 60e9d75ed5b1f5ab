from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_opening, convolve1d

from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.body.contacts import (
    BITS,
    SHORTEST,
    _fast,
    _frames,
    _lasting,
    _loading,
    feet_down,
    foot_contacts,
    left_strike,
    smoothed_bits,
    speeds_and_heights,
)
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT, Contact, contacts_of, which_stand
from tests import naive

DUTY = {"walk": 0.62, "slow_walk": 0.62, "run": 0.335, "stairs_up": 0.63, "stairs_down": 0.62}


def phases_of(clip_name: str, seed: int) -> tuple[list[Contact], float]:
    """Returns the contacts of a built-in motion, and the duration of its stride in seconds."""
    clip = make(clip_name, seed=seed)
    roles = find_roles(clip.skeleton)
    contacts = contacts_of(foot_contacts(clip, roles), clip.rate)
    downs = [one.down for one in contacts if one.foot == "left" and one.down > 0.0]
    return contacts, float(np.median(np.diff(downs)))


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("gait", DUTY)
def test_feet_alternate_and_stand_about_as_long_as_the_gait_says(gait: str, seed: int) -> None:
    contacts, stride = phases_of(gait, seed)
    whole = [one for one in contacts if one.down > 0.1 and one.up < 5.8]
    assert [one.foot for one in whole] in (
        ["left", "right"] * (len(whole) // 2) + ["left"] * (len(whole) % 2),
        ["right", "left"] * (len(whole) // 2) + ["right"] * (len(whole) % 2),
    )
    assert np.mean([one.up - one.down for one in whole]) / stride == pytest.approx(DUTY[gait], abs=0.12)
    between = [b.down - a.down for a, b in itertools.pairwise(whole)]
    np.testing.assert_allclose(between, 0.5 * stride, atol=0.1 * stride)


def test_phase_is_a_whole_number_where_the_left_foot_comes_down() -> None:
    clip = make("walk", seed=3)
    roles = find_roles(clip.skeleton)
    phase = align(clip, roles, find_baseline(clip, roles)).phase
    for one in contacts_of(foot_contacts(clip, roles), clip.rate):
        if one.down > 0.1:
            at = np.interp(one.down * clip.rate, np.arange(len(phase)), phase)
            wanted = 0.0 if one.foot == "left" else 0.5
            assert abs((at - wanted + 0.5) % 1.0 - 0.5) < 0.04


def test_contacts_are_runs_of_frames() -> None:
    both = LEFT_FOOT | RIGHT_FOOT
    standing = np.array([0, LEFT_FOOT, both, both, RIGHT_FOOT, 0, LEFT_FOOT], np.uint8)
    found = [("left", 0.1, 0.3), ("right", 0.2, 0.4), ("left", 0.6, 0.6)]
    for contact, (foot, down, up) in zip(contacts_of(standing, 10.0), found, strict=True):
        assert contact.foot == foot
        np.testing.assert_allclose([contact.down, contact.up], [down, up])


def test_feet_that_do_not_come_down_have_no_strike() -> None:
    clip = make("walk", seed=3).frames(0, 40)
    assert left_strike(foot_contacts(clip, find_roles(clip.skeleton)), clip.rate, 10.0, 11.0) is None


@given(arrays(np.uint8, st.tuples(st.integers(1, 60), st.just(2)), elements=st.integers(0, 1)), st.floats(20.0, 240.0))
def test_short_gaps_and_contacts_go_as_by_binary_closing_and_opening(feet: NDArray[np.uint8], rate: float) -> None:
    lasting = _lasting(feet, rate)
    for foot in range(2):
        brief = np.ones(_frames(SHORTEST, rate), np.bool_)
        padded = np.pad(feet[:, foot], len(brief), mode="edge")
        wanted = binary_opening(binary_closing(padded, brief), brief)[len(brief) : -len(brief)]
        np.testing.assert_array_equal(lasting[:, foot], wanted)


@given(
    arrays(np.float64, st.tuples(st.integers(2, 40), st.integers(1, 3), st.just(3)), elements=st.floats(-2.0, 2.0)),
    st.sampled_from([3, 5, 7]),
    st.sampled_from([3, 9, 15]),
)
def test_speeds_and_heights_are_those_of_the_slow_twin(paths: Floats, smoothed: int, reach: int) -> None:
    speeds, above = speeds_and_heights(paths, 1.0 / 30.0, smoothed, reach)
    wanted = naive.speeds_and_heights(paths, 1.0 / 30.0, smoothed, reach)
    np.testing.assert_allclose(speeds, wanted[0], atol=1e-11)
    np.testing.assert_array_equal(above, wanted[1])


@given(arrays(np.float64, st.tuples(st.integers(1, 60), st.integers(1, 3)), elements=st.floats(0.0, 9.0)))
def test_the_fast_speed_is_the_95th_percentile(speeds: Floats) -> None:
    np.testing.assert_array_equal(_fast(speeds), np.percentile(speeds, 95.0, axis=0))


@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(1, 2), st.integers(1, 2))
def test_a_foot_stands_if_one_of_its_joints_is_slow_and_low(seed: int, frames: int, left: int, right: int) -> None:
    rng = np.random.default_rng(seed)
    (speeds, above), slow = rng.random((2, frames, left + right)), rng.random(left + right)
    stands = (speeds < slow) & (above < 0.6)
    wanted = np.stack([stands[:, :left].any(axis=1), stands[:, left:].any(axis=1)], axis=1)
    np.testing.assert_array_equal(feet_down(speeds, above, slow, 0.6, left), wanted)


@given(arrays(np.uint8, st.integers(1, 60), elements=st.integers(0, 3)), st.floats(10.0, 240.0))
def test_support_is_smoothed_as_by_scipy(standing: NDArray[np.uint8], rate: float) -> None:
    window = _loading(rate)
    wanted = convolve1d(which_stand(standing).astype(np.float64), window, axis=0, mode="nearest")
    np.testing.assert_allclose(smoothed_bits(standing, BITS, window), wanted, rtol=0.0, atol=1e-15)
    assert window.sum() == pytest.approx(1.0)
