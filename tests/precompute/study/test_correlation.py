from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.errors import BaselineError, ClipError
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.procedural.variants import local_axes, uneven_time, warped, with_local_axes
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.splice import splice_exact, splice_naive
from motionsplice.precompute.study.body_angles import Axis, Curve, View
from motionsplice.precompute.study.correlation import (
    LEVEL,
    Correlation,
    Key,
    Study,
    Survival,
    Verdict,
    correlate,
    lag_between,
    largest_real,
    study,
    survival,
)
from motionsplice.precompute.study.periodic import Period, drift, trend
from tests.conftest import CLIPS

ROLES = find_roles(CLIPS["walk"].skeleton)
WALK = study(CLIPS["walk"], ROLES)
SPINE_TWIST = Key(View.LOCAL, Period.STRIDE, Axis.TWIST, "shoulders over hips")
HEAD_TWIST = Key(View.LOCAL, Period.STRIDE, Axis.TWIST, "head over shoulders")
BOBS = [Key(View.GLOBAL, Period.STEP, Axis.BEND, joint) for joint in ("pelvis", "spine 1", "spine 2", "neck")]
REAL_WALKS = {"16_15.amc": 0, "16_11.amc": 0, "06_01.bvh": 1, "02_01.amc": 0, "08_07.bvh": 1}


def phase_of(strides: float, frames: int = 400) -> Floats:
    """Returns the phase of a gait of uneven speed."""
    part = np.linspace(0.0, 1.0, frames)
    return np.asarray(0.3 + strides * (part + 0.02 * np.sin(2.0 * np.pi * part)))


def curve(angles: Floats, joint: str = "spine 1") -> Curve:
    return Curve(View.LOCAL, joint, Axis.TWIST, angles)


def at(period: Period, *curves: Curve, phase: Floats) -> list[Correlation]:
    return [one for one in correlate(curves, phase) if one.period is period]


@settings(max_examples=40)
@given(
    period=st.sampled_from(Period),
    lag=st.floats(-3.1, 3.1),
    amplitude=st.floats(0.01, 1.0),
    strides=st.floats(2.0, 6.0),
    slope=st.floats(-1.0, 1.0),
)
def test_lag_and_amplitude_of_a_wave_are_recovered(
    period: Period, lag: float, amplitude: float, strides: float, slope: float
) -> None:
    phase = phase_of(strides)
    wave = amplitude * np.cos(2.0 * np.pi * period * phase - lag)
    (found,) = at(period, curve(wave + slope * phase), phase=phase)
    assert found.amplitude == pytest.approx(amplitude, rel=0.01)
    assert abs(np.angle(np.exp(1j * (found.lag - lag)))) < 0.01
    assert found.strength > 0.999
    assert found.verdict.correlated


@pytest.mark.parametrize(
    ("degrees", "verdict"),
    [(0, Verdict.IN_PHASE), (-40, Verdict.IN_PHASE), (180, Verdict.OPPOSITE), (-140, Verdict.OPPOSITE),
     (90, Verdict.AT_A_LAG), (-90, Verdict.AT_A_LAG)],
)  # fmt: skip
def test_the_lag_decides_the_verdict(degrees: float, verdict: Verdict) -> None:
    phase = phase_of(3.4)
    (found,) = at(Period.STRIDE, curve(0.1 * np.cos(2.0 * np.pi * phase - np.radians(degrees))), phase=phase)
    assert found.verdict is verdict


def test_a_curve_that_hardly_moves_is_still_even_if_perfectly_in_time() -> None:
    phase = phase_of(4.0)
    (found,) = at(Period.STEP, curve(np.radians(0.25) * np.cos(4.0 * np.pi * phase)), phase=phase)
    assert found.verdict is Verdict.STILL
    assert found.p == 1.0


@pytest.mark.parametrize("strides", [2.0, 2.5, 3.3, 5.0])
@pytest.mark.parametrize(("smoothness", "most"), [(0, 2.0), (12, 3.2)])
def test_noise_passes_about_as_often_as_the_level_says(strides: float, smoothness: int, most: float) -> None:
    random = np.random.default_rng(smoothness)
    phase = phase_of(strides, round(130 * strides))
    noise = random.normal(size=(150, len(phase) + 400))
    smooth = gaussian_filter1d(noise, smoothness, axis=1) if smoothness else noise
    lines = [curve(line) for line in smooth[:, 200:-200]]
    for period in Period:
        p = np.array([one.p for one in at(period, *lines, phase=phase)])
        assert np.mean(p <= LEVEL) < most * LEVEL  # of 150 curves; noise as slow as a step passes twice as often
        assert np.mean(p <= 0.5) > 0.3


def test_few_motions_of_pure_noise_have_a_correlation() -> None:
    random = np.random.default_rng(5)
    phase = phase_of(3.0, 300)
    found = [
        sum(one.verdict.correlated for one in correlate(tuple(curve(line) for line in lines), phase))
        for lines in random.normal(size=(40, 12, 300))
    ]
    assert np.mean(np.array(found) > 0) < 0.15


@pytest.mark.parametrize("frequency", [0.4, 0.6, 1.4, 1.6, 2.5])
def test_a_curve_of_another_rhythm_is_not_correlated(frequency: float) -> None:
    phase = phase_of(4.2)
    starts = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    lines = [curve(0.2 * np.cos(2.0 * np.pi * frequency * phase + start)) for start in starts]
    assert not any(one.verdict.correlated for one in correlate(tuple(lines), phase))


def test_randomly_shifted_strides_are_not_correlated() -> None:
    phase = phase_of(5.0, 650)
    shifts = np.array([0.0, 2.1, 4.4, 1.0, 3.5])[np.minimum((phase - phase[0]).astype(int), 4)]
    (found,) = at(Period.STRIDE, curve(0.2 * np.cos(2.0 * np.pi * phase + shifts)), phase=phase)
    assert found.verdict is Verdict.NONE


@given(p=st.lists(st.floats(0.0, 1.0), max_size=60))
def test_the_bound_on_p_lies_between_bonferroni_and_the_level(p: list[float]) -> None:
    bound = largest_real(np.array(p))
    assert bound <= LEVEL
    assert bound >= max((one for one in p if one <= LEVEL / len(p)), default=0.0)


def test_the_trend_keeps_both_periods_and_removes_noise() -> None:
    phase = phase_of(3.0)
    wave = np.cos(2.0 * np.pi * phase) + 0.3 * np.sin(4.0 * np.pi * phase)
    noise = np.random.default_rng(2).normal(scale=0.2, size=len(phase))
    assert np.abs(trend(wave, phase) - wave)[10:-10].max() < 0.02
    assert np.std(trend(wave + noise, phase) - wave) < 0.5 * np.std(noise)


@given(strides=st.floats(2.0, 8.0), size=st.floats(-3.0, 3.0))
def test_the_drift_of_a_turn_excludes_the_sway(strides: float, size: float) -> None:
    phase = phase_of(strides)
    turn = size * (phase - phase[0]) ** 2 / strides**2
    found = drift(turn + 0.1 * np.cos(2.0 * np.pi * phase) + 0.05 * np.sin(4.0 * np.pi * phase), phase)
    np.testing.assert_allclose(found, turn, atol=1e-6)


def check_walk(found: Study, *, head: bool = True) -> None:
    """Checks what the thesis found in all its examples."""
    correlations = found.found
    assert any(bob in correlations for bob in BOBS)
    assert correlations[SPINE_TWIST].verdict is Verdict.IN_PHASE
    if head:
        assert abs(lag_between(correlations[SPINE_TWIST], correlations[HEAD_TWIST])) > np.radians(140.0)


def test_the_built_in_walk_bobs_and_twists_and_its_head_turns_back() -> None:
    check_walk(WALK)
    again = study(make("walk", seed=9, seconds=4.0), ROLES)
    check_walk(again)


@pytest.mark.parametrize("name", REAL_WALKS)
def test_real_walks_bob_and_twist_and_their_heads_turn_back(name: str, real_motion: Path) -> None:
    reading = read_clip(real_motion / name, skip_frames=REAL_WALKS[name])
    # 02_01 has 2.5 strides, and its head turns a quarter of a stride after the spine. These are too few strides to
    # distinguish its head turn from chance.
    check_walk(study(reading.clip, reading.roles), head=name != "02_01.amc")


def test_a_real_splice_keeps_what_a_naive_one_loses(real_motion: Path) -> None:
    curve, walk = (read_clip(real_motion / f"{name}.amc") for name in ("16_17", "16_15"))
    exact = splice_exact(curve.clip, walk.clip, curve.roles).clip
    naive = splice_naive(curve.clip, walk.clip, curve.roles).frames(0, exact.frame_count)
    truth, ours, theirs = (study(clip, curve.roles) for clip in (curve.clip.frames(0, exact.frame_count), exact, naive))
    kept = [sum(survival(one, other) is Survival.KEPT for one in truth.found.values()) for other in (ours, theirs)]
    assert kept[0] > 0.5 * len(truth.found)
    assert kept[1] < 0.2 * len(truth.found), kept


def test_the_answer_does_not_depend_on_local_axes() -> None:
    clip = CLIPS["walk"]
    turned = study(with_local_axes(clip, local_axes(clip.skeleton.joint_count, seed=4)), ROLES)
    for one, other in zip(WALK.correlations, turned.correlations, strict=True):
        assert (one.key, one.verdict) == (other.key, other.verdict)
        assert one.amplitude == pytest.approx(other.amplitude, abs=1e-6)
        if one.verdict.correlated:
            assert abs(lag_between(one, other)) < 1e-4
            assert one.p == pytest.approx(other.p, abs=0.002)


def test_a_walk_of_uneven_speed_keeps_its_correlations_with_the_stride() -> None:
    clip = CLIPS["walk"]
    other = study(warped(clip, uneven_time(clip.frame_count), "uneven"), ROLES)
    for key, one in WALK.found.items():
        if key.period is Period.STRIDE:
            assert survival(one, other) is Survival.KEPT
            assert abs(lag_between(one, other.found[key])) < np.radians(12.0)
            assert one.amplitude == pytest.approx(other.found[key].amplitude, rel=0.1, abs=np.radians(0.3))


def test_the_legs_of_a_walk_are_foremost_at_whole_strides() -> None:
    apart = WALK.thighs[0] - WALK.thighs[1]
    nearest = np.abs(WALK.phase - np.round(WALK.phase))
    assert apart[nearest < 0.02].min() > 0.8 * apart.max()
    assert apart[nearest > 0.48].max() < 0.8 * apart.min()


def test_a_late_upper_body_is_changed_and_a_shuffled_one_is_lost() -> None:
    clip = CLIPS["walk"]
    upper = clip.skeleton.subtree(ROLES.pelvis)

    def with_upper_of(frames: Floats) -> Study:
        lower = clip.frames(0, len(frames))
        rotations = lower.rotations.copy()
        rotations[:, upper] = clip.sampled(frames)[1][:, upper]
        return study(replace(lower, rotations=rotations), ROLES)

    frames = np.arange(clip.frame_count, dtype=np.float64)
    stride = float(np.interp(WALK.phase[0] + 1.0, WALK.phase, frames))
    early, slow = with_upper_of(frames[: -round(0.4 * stride)] + 0.4 * stride), with_upper_of(0.72 * frames)
    for key in (Key(View.GLOBAL, Period.STRIDE, Axis.BEND, "left shoulder"), HEAD_TWIST):
        one = WALK.found[key]
        assert survival(one, WALK) is Survival.KEPT
        assert survival(one, slow) is Survival.LOST
        assert survival(one, early) is Survival.CHANGED
        assert np.degrees(lag_between(one, early.found[key])) == pytest.approx(-144.0, abs=8.0)


def test_a_motion_of_less_than_two_strides_is_refused() -> None:
    clip = CLIPS["walk"]
    stride = int(np.searchsorted(WALK.phase, WALK.phase[0] + 1.0))
    for count in (1, 2, 20):
        with pytest.raises(BaselineError, match="no stride"):
            study(clip.frames(0, count), ROLES)
    with pytest.raises(ClipError, match=r"1\.. strides"):
        study(clip.frames(0, round(1.3 * stride)), ROLES)
