from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion.errors import ClipError, SettingsError
from motionsplice.motion.procedural.gestures import GesturePair, gesture_pair
from motionsplice.motion.procedural.score import least_jerk
from motionsplice.motion.quaternion import about, rotate
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.hands import banded_warp
from motionsplice.precompute.hands.align import align_hands
from motionsplice.precompute.hands.banded_warp import Band, FramePair, straight_band
from motionsplice.precompute.hands.costs import Comparison
from motionsplice.precompute.hands.phases import Phase, count_phases, derivatives, phases
from motionsplice.precompute.hands.points import HandMotion, hand_motion
from tests import naive_hands

RATE = 60.0


def motions(pair: GesturePair, side: Any = "right") -> tuple[HandMotion, HandMotion]:
    return tuple(hand_motion(clip, find_roles(clip.skeleton), side) for clip in (pair.body, pair.hands))  # type: ignore[return-value]


@pytest.fixture(scope="module")
def pair() -> GesturePair:
    return gesture_pair(21, kinds=["point", "count", "wave"], seconds=4.0, hand="right")


@pytest.fixture(scope="module")
def both(pair: GesturePair) -> tuple[HandMotion, HandMotion]:
    return motions(pair)


def whole(frames: int, others: int) -> Band:
    return Band(np.zeros(frames, np.int64), np.full(frames, others - 1))


def test_costs_equal_those_of_the_readable_twin(both: tuple[HandMotion, HandMotion]) -> None:
    body, hands = both
    compared, band = Comparison(body, hands, RATE), straight_band(len(body.points), len(hands.points), 0.3, [])
    phase_costs, palm_costs, pace_costs = compared.phases(band), compared.palms(band), compared.paces(band)
    draw, unequal = np.random.default_rng(0), 0
    for _ in range(12):
        i = int(draw.integers(len(body.points)))
        j = int(draw.integers(band.low[i], band.high[i] + 1))
        turned = naive_hands.turn(body, hands, i, j)
        at = i, j - int(band.low[i])
        unequal += phase_costs[at] != naive_hands.phase_cost(body, hands, RATE, i, j, turned)
        assert pace_costs[at] == pytest.approx(naive_hands.pace_cost(body, hands, RATE, i, j, turned), rel=5e-3)
        assert palm_costs[at] == pytest.approx(naive_hands.palm_cost(body, hands, i, j, turned), abs=2e-3)
    assert unequal <= 2  # the twin tries 7,200 turns; between two of them a sign may change


def test_hands_can_be_turned_by_the_trunk(both: tuple[HandMotion, HandMotion]) -> None:
    body, hands = both
    assert body.trunk is not None
    assert hands.trunk is not None
    compared = Comparison(body, hands, RATE, by_trunk=True)
    costs = compared.phases(whole(len(body.points), len(hands.points)))
    for i, j in ((20, 30), (100, 90), (200, 201)):
        turned = about(naive_hands.UP, float(body.trunk[i] - hands.trunk[j]))
        assert costs[i, j] == naive_hands.phase_cost(body, hands, RATE, i, j, turned)
    with pytest.raises(SettingsError, match="the heading of the trunk is unknown"):
        Comparison(HandMotion(body.points), hands, RATE, by_trunk=True)


@pytest.mark.parametrize(
    ("pairs", "words"),
    [
        ([FramePair(10, 5), FramePair(20, 4)], "pair 20:4: it crosses the pair 10:5"),
        ([FramePair(10, 5, 2), FramePair(10, 9)], "pair 10:9: the pair 10:5~2 has the same frame"),
        ([FramePair(50, 5)], "pair 50:5: frame 50 of the body lies outside the clip, whose last frame is 49"),
        ([FramePair(5, 40, 3)], "pair 5:40~3: frame 40 of the hands lies outside the clip, whose last frame is 39"),
    ],
)
def test_impossible_pairs_are_named_in_the_error(pairs: list[FramePair], words: str) -> None:
    hand = HandMotion(np.random.default_rng(0).normal(size=(50, 4, 3)))
    with pytest.raises(SettingsError) as raised:
        align_hands([hand], [HandMotion(hand.points[:40])], RATE, pairs=pairs)
    assert words in str(raised.value)


def test_invalid_and_too_large_bands_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    hand = HandMotion(np.zeros((50, 4, 3)) + np.arange(3.0))
    for bands in ((0.0, 0.1), (0.3, -1.0), (np.nan, 0.1), (0.3, 2.0)):
        with pytest.raises(SettingsError, match="bands must be above 0 and at most 1"):
            align_hands([hand], [hand], RATE, bands=bands)
    monkeypatch.setattr(banded_warp, "MOST_CELLS", 100)
    with pytest.raises(ClipError, match="need a band of 2,150 cells, more than the limit of 100"):
        align_hands([hand], [hand], RATE)


def test_a_hand_aligned_with_itself_keeps_its_frames(both: tuple[HandMotion, HandMotion]) -> None:
    for hand in both:
        found = align_hands([hand], [hand], RATE)
        np.testing.assert_allclose(found.frames, np.arange(len(hand.points)), atol=0.5)


@given(st.floats(0.7, 1.4), st.floats(0.25, 1.0), st.floats(-3.0, 3.0))
@settings(max_examples=12)
def test_the_timing_of_a_warped_scaled_and_turned_copy_is_recovered(tempo: float, size: float, facing: float) -> None:
    hand = motions(gesture_pair(9, kinds=["point", "wave", "count"], seconds=4.0, hand="right"))[0]
    count = len(hand.points)
    bend = 0.12 * np.sin(2.0 * np.pi * np.linspace(0.0, 1.0, count))
    at = (np.linspace(0.0, 1.0, count) + bend * 0.8) * round((count - 1) * tempo)
    read = np.interp(np.arange(round((count - 1) * tempo) + 1), at, np.arange(count))
    copied = np.stack([[np.interp(read, np.arange(count), hand.points[:, p, c]) for c in range(3)] for p in range(4)])
    turned = rotate(about(naive_hands.UP, facing), size * np.moveaxis(copied, 2, 0))
    found = align_hands([hand], [HandMotion(turned)], RATE)
    apart = np.abs(found.frames - at)
    assert np.median(apart) < 1.0
    assert np.percentile(apart, 95.0) < 5.0


def test_generated_timing_is_found_at_any_size_and_with_noise() -> None:
    for seed, size in ((1, (0.2, 0.3)), (2, (0.5, 1.0))):
        draw, pair = np.random.default_rng(seed), gesture_pair(seed, gestures=9, seconds=6.0, amplitude=size)
        noisy: list[list[HandMotion]] = [[], []]
        for side in ("left", "right"):
            for which, one in enumerate(motions(pair, side)):
                noisy[which].append(replace(one, points=one.points + draw.normal(0.0, 0.002, one.points.shape)))
        apart = np.abs(align_hands(noisy[0], noisy[1], RATE).frames - pair.hand_frames)
        assert np.median(apart) < 1.0
        assert np.percentile(apart, 95.0) < 6.0


def test_an_alignment_does_not_depend_on_the_performers_facing(
    both: tuple[HandMotion, HandMotion],
) -> None:
    body, hands = both
    found = align_hands([body], [hands], RATE)
    turned = HandMotion(rotate(about(naive_hands.UP, 2.0), hands.points), None)
    np.testing.assert_allclose(align_hands([body], [turned], RATE).frames, found.frames, atol=0.6)


def test_a_still_hand_is_one_hold_and_is_aligned_evenly() -> None:
    draw = np.random.default_rng(3)
    place = draw.normal(size=(1, 4, 3))
    still = HandMotion(place + draw.normal(0.0, 0.002, (240, 4, 3)))
    found = derivatives(still.points, RATE)
    assert (np.abs(found.velocity) > found.still).mean() < 0.01
    assert [phase.kind for phase in phases(still, RATE)] == ["hold"]
    exact = HandMotion(np.tile(place, (120, 1, 1)))
    aligned = align_hands([exact], [HandMotion(np.tile(place, (60, 1, 1)))], RATE)
    assert aligned.frames[0] == pytest.approx(0.0, abs=1.0)
    assert aligned.frames[-1] == pytest.approx(59.0, abs=1.0)


@pytest.mark.parametrize("counts", [(1, 1), (2, 1), (1, 5), (5, 5), (5, 2), (3, 40)])
def test_clips_of_few_frames_are_aligned(counts: tuple[int, int]) -> None:
    draw = np.random.default_rng(0)
    body, hands = (HandMotion(draw.normal(size=(count, 4, 3))) for count in counts)
    frames = align_hands([body], [hands], RATE).frames
    assert frames.shape == (counts[0],)
    assert np.all((frames >= 0.0) & (frames <= counts[1] - 1.0))
    assert np.all(np.diff(frames) >= 0.0)


def test_pairs_at_both_ends_move_the_ends(both: tuple[HandMotion, HandMotion]) -> None:
    body, hands = both
    last = len(body.points) - 1
    frames = align_hands([body], [hands], RATE, pairs=[FramePair(0, 9, 1), FramePair(last, 120)]).frames
    assert 8.0 <= frames[0] <= 10.0
    assert frames[-1] == 120.0


def test_pairs_help_where_gestures_repeat() -> None:
    better = 0
    for seed in range(6):
        pair = gesture_pair(seed, kinds=["count"] * 5, seconds=6.0, hand="right")
        body, hands = motions(pair)
        ends = [round(span.end) for span in pair.spans if span.kind == "stroke"]
        twice = np.concatenate(
            [hands.points[: round(pair.hand_frames[ends[2]])], hands.points[round(pair.hand_frames[ends[1]]) :]]
        )
        longer = len(twice) - len(hands.points)
        truth = np.where(np.arange(len(body.points)) < ends[2], pair.hand_frames, pair.hand_frames + longer)
        pairs = [FramePair(end, round(truth[end]), 2) for end in (ends[0], ends[1], ends[3])]
        without, given = (align_hands([body], [HandMotion(twice)], RATE, pairs=some).frames for some in ([], pairs))
        assert all(abs(given[one.body] - one.hands) <= one.tolerance for one in pairs)
        better += np.abs(given - truth).mean() <= np.abs(without - truth).mean() + 0.1
    assert better >= 5


def out_and_back() -> HandMotion:
    """A hand that goes out, holds, and comes back at half the speed."""
    time = np.arange(181) / RATE
    distance = 0.3 * (least_jerk((time - 0.5) / 0.4) - least_jerk((time - 1.5) / 0.8))
    hand = np.array([[0.0, -0.3, 0.2], [0.04, -0.3, 0.2], [0.0, -0.2, 0.1], [0.0, -0.32, 0.28]])
    return HandMotion(hand + distance[:, None, None] * [0.0, 0.0, 1.0])


def test_a_gesture_has_the_phases_of_table_1() -> None:
    found = phases(out_and_back(), RATE)
    assert [phase.kind for phase in found] == ["hold", "preparation", "hold", "retraction", "hold"]
    assert count_phases(found) == {"hold": 3, "preparation": 1, "retraction": 1}
    np.testing.assert_allclose([phase.begin for phase in found], [0, 30, 54, 90, 138], atol=5)
    assert [phase.end for phase in found[:-1]] == [phase.begin for phase in found[1:]]
    assert found[-1].end == 181


def test_phases_of_a_short_clip_are_one_hold() -> None:
    assert phases(HandMotion(np.zeros((2, 4, 3)) + np.arange(3.0)), RATE) == [Phase("hold", 0, 2)]


@pytest.mark.parametrize("size", [0.0, 1e-200, 1e200])
def test_points_of_zero_or_huge_size_can_be_aligned(size: float) -> None:
    draw = np.random.default_rng(0)
    body, hands = (HandMotion(draw.normal(size=(count, 4, 3)) * size) for count in (20, 30))
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        frames = align_hands([body], [hands], RATE).frames
    assert np.all(np.diff(frames) >= 0.0)
    assert 0.0 <= frames[0] <= frames[-1] <= 29.0


def test_motion_too_large_to_compare_is_refused() -> None:
    far = HandMotion(np.random.default_rng(0).normal(size=(20, 4, 3)) * 1e306)
    with np.errstate(all="ignore"), pytest.raises(ClipError, match="too far to be compared"):
        align_hands([far], [far], RATE)
