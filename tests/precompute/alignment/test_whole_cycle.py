from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import BaselineError
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.alignment.whole_cycle import find_period, played_on
from tests.conftest import CLIPS
from tests.whole_cycles import FIRST, RATE, cut, motion_of, seconds_of

GAITS = ("walk", "run", "slow_walk", "side_step", "curve", "stairs_up")
ROLES = find_roles(CLIPS["walk"].skeleton)
RIGS = Path(__file__).parents[4] / "shared" / "mocap" / "rigs"


@pytest.mark.parametrize("open_end", [False, True])
@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0])
@pytest.mark.parametrize("gait", GAITS)
def test_one_cycle_is_a_stride_wherever_it_begins(gait: str, rate: float, open_end: bool) -> None:
    period = round(seconds_of(gait) * rate)
    for eighth, in_place in product(range(8), (False, True)):
        clip = cut(gait, rate=rate, start=eighth / 8.0, open_end=open_end, in_place=in_place)
        assert find_period(clip, ROLES) == period
        stride = find_baseline(clip, ROLES)
        assert stride.start == 0.0
        assert stride.end * rate == pytest.approx(period)
        assert len(stride.clouds) == round(stride.end * 30.0)


@given(st.sampled_from(["walk", "run"]), st.floats(30.0, 120.0), st.floats(0.0, 1.0), st.booleans(), st.booleans())
@settings(max_examples=60)
def test_the_period_of_a_cycle_is_exact(gait: str, rate: float, start: float, open_end: bool, in_place: bool) -> None:
    clip = cut(gait, rate=rate, start=start, open_end=open_end, in_place=in_place)
    assert find_period(clip, ROLES) == round(seconds_of(gait) * rate)


@given(st.sampled_from(GAITS), st.floats(24.0, 120.0), st.floats(0.0, 1.0), st.floats(0.4, 0.87) | st.floats(1.13, 1.4))
@settings(max_examples=60)
def test_part_of_a_cycle_and_more_than_one_are_no_whole_cycle(
    gait: str, rate: float, start: float, cycles: float
) -> None:
    assert find_period(cut(gait, rate=rate, start=start, cycles=cycles), ROLES) is None


@pytest.mark.parametrize("open_end", [False, True])
def test_half_a_cycle_is_no_stride(open_end: bool) -> None:
    for eighth in range(8):
        half = cut("slow_walk", start=eighth / 8.0, cycles=0.5, open_end=open_end)
        with pytest.raises(BaselineError, match="has no stride"):
            find_baseline(half, ROLES)


@pytest.mark.parametrize(("cycles", "faster"), [(2, 1.0), (2, 1.35), (3, 1.25), (3, 1.35)])
def test_several_cycles_are_several_strides(cycles: int, faster: float) -> None:
    clip = cut("run", rate=24.0, cycles=cycles, start=0.3)
    clip = replace(clip, rate=24.0 * faster)  # three strides must last as long as one may last
    assert find_period(clip, ROLES) == clip.frame_count - 1
    stride = find_baseline(clip, ROLES)
    assert stride.end - stride.start == pytest.approx(seconds_of("run") / faster, abs=1.5 / clip.rate)


def swayed(clip: Clip, joints: list[int], radians: np.ndarray) -> Clip:
    """Returns a clip that holds the first frame, with joints turned about X by `radians` [F]."""
    rotations = np.repeat(clip.rotations[:1], len(radians), axis=0)
    rotations[:, joints] = quaternion.multiply(
        rotations[:, joints], quaternion.about([1.0, 0.0, 0.0], radians)[:, None]
    )
    return replace(clip, root_positions=np.repeat(clip.root_positions[:1], len(radians), axis=0), rotations=rotations)


def test_standing_still_is_no_stride_though_its_ends_match() -> None:
    breath = 0.02 * np.sin(np.linspace(0.0, 2.0 * np.pi, 31))
    idle = swayed(cut("walk"), [ROLES.left_hip, ROLES.right_hip, ROLES.left_knee, *ROLES.spine], breath)
    assert find_period(idle, ROLES) == 30
    with pytest.raises(BaselineError, match="has no stride"):
        find_baseline(idle, ROLES)


def test_an_action_that_begins_and_ends_at_rest_is_no_cycle() -> None:
    bend = np.sin(np.linspace(0.0, np.pi, 31)) ** 2
    assert find_period(swayed(cut("walk"), [ROLES.left_hip, ROLES.right_hip, ROLES.left_knee], bend), ROLES) is None


def test_a_walk_whose_arm_does_not_return_is_no_cycle() -> None:
    clip = cut("walk")
    rotations = clip.rotations.copy()
    raised = quaternion.about([1.0, 0.0, 0.0], np.linspace(0.0, 0.8, clip.frame_count))
    rotations[:, ROLES.left_shoulder] = quaternion.multiply(rotations[:, ROLES.left_shoulder], raised)
    assert find_period(replace(clip, rotations=rotations), ROLES) is None


@pytest.mark.parametrize("open_end", [False, True])
def test_a_walk_whose_arm_waves_at_another_tempo_is_no_cycle(open_end: bool) -> None:
    for eighth in range(8):
        clip = cut("walk", "wave", rate=24.0, start=eighth / 8.0, open_end=open_end)
        assert find_period(clip, ROLES) is None


@pytest.mark.parametrize("rate", [30.0, 60.0])
@pytest.mark.parametrize("open_end", [False, True])
@pytest.mark.parametrize("gait", GAITS)
def test_a_cycle_played_on_goes_where_the_motion_went(gait: str, open_end: bool, rate: float) -> None:
    clip = cut(gait, rate=rate, start=0.2, open_end=open_end)
    period = round(seconds_of(gait) * rate)
    played = played_on(clip, period, ROLES)
    assert played.frame_count == 4 * period
    laps = np.arange(3 * period) / period  # from the clip's own on
    sampled = motion_of(gait).sampled(FIRST + (0.2 + laps) * seconds_of(gait) * RATE)
    truth = joint_positions(replace(played, root_positions=sampled[0], rotations=sampled[1]))
    assert np.linalg.norm(joint_positions(played)[period:] - truth, axis=-1).max() < 0.03


@pytest.mark.parametrize("open_end", [False, True])
def test_a_cycle_in_place_stays_there(open_end: bool) -> None:
    clip = cut("walk", open_end=open_end, in_place=True)
    played = played_on(clip, 30, ROLES)
    for lap in range(4):
        one = played.frames(30 * lap, 30 * (lap + 1))
        np.testing.assert_allclose(one.root_positions, clip.root_positions[:30], atol=1e-12)
        assert quaternion.angle(one.rotations, clip.rotations[:30]).max() < 1e-7


@pytest.mark.parametrize(("name", "frames"), [("walk", 40), ("run", 20), ("jog", 24)])
def test_loops_of_a_game_are_strides(name: str, frames: int) -> None:
    file = RIGS / f"{name}.fbx"
    if not file.exists():
        pytest.skip("rigs not found (../shared/mocap/rigs)")
    pytest.importorskip("ufbx")
    reading = read_clip(file)
    stride = find_baseline(reading.clip, reading.roles)
    assert stride.start == 0.0
    assert stride.end == pytest.approx(frames / 30.0)
