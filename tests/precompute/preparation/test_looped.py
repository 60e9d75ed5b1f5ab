from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.alignment.whole_cycle import find_period
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.preparation.looped import loop
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Posture
from motionsplice.runtime.stage import Stage
from tests.conftest import CLIPS
from tests.whole_cycles import cut, motion_of, seconds_of

GAITS = ("walk", "run", "slow_walk", "side_step", "curve", "stairs_up")
ROLES = find_roles(CLIPS["walk"].skeleton)
RING = find_baseline(CLIPS["walk"], ROLES)
CYCLES = {
    "closed": cut("walk", rate=30.0, start=0.4),
    "open": cut("walk", rate=24.0, start=0.7, open_end=True),
    "run": cut("run", rate=24.0, start=0.1),
    "run_in_place": cut("run", rate=30.0, start=0.125, open_end=True, in_place=True),
    "curve": cut("curve", rate=60.0, start=0.2, open_end=True),
    "stairs": cut("stairs_up", rate=30.0, start=0.5),
    "box": cut("walk", "carry_box", rate=30.0, start=0.3),
    "push": cut("walk", "push", rate=24.0, start=0.8, open_end=True),
}
SOURCES: dict[str, tuple[str, ...]] = {
    "closed": ("walk",),
    "open": ("walk",),
    "run": ("run",),
    "run_in_place": ("run",),
    "curve": ("curve",),
    "stairs": ("stairs_up",),
    "box": ("walk", "carry_box"),
    "push": ("walk", "push"),
}
LONG = {"long_box": make("walk", "carry_box", seed=1, seconds=12.0), "long_push": make("walk", "push", seconds=12.0)}
ACTIONS = ("box", "push")
SECONDS = 10.0  # less than the long actions take, so that they do not loop


@pytest.fixture(scope="module")
def cycles(tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """A bank of whole cycles, and two long actions; none of its locomotions is longer than a cycle."""
    folder = tmp_path_factory.mktemp("cycles")
    for name, clip in {**CYCLES, **LONG}.items():
        (folder / f"{name}.bvh").write_bytes(dump_bvh(clip))
    settings = "".join(f'[{name}]\nkind = "action"\nneutral = "closed"\n' for name in (*ACTIONS, *LONG))
    (folder / "clips.toml").write_text(settings)
    outcome = build_bank([folder], folder / "bank", jobs=1)
    assert not outcome.failed
    return Bank.open(folder / "bank")


def played(
    bank: Bank, locomotion: str, action: str | None = None, posture: Posture = "relative", *, rate: float = 60.0
) -> Clip:
    """Returns SECONDS of a character."""
    evaluator = Evaluator(bank)
    characters = Characters(Stage(evaluator), rate)
    (row,) = characters.add(1, locomotion)
    if action is not None:
        characters.act([row], Action(action, blend=0.0, posture=posture))
    poses, positions, rotations = evaluator.poses(1), [], []
    for _ in range(int(SECONDS * rate)):
        characters.evaluate(poses)
        positions.append(poses.root_positions[0].copy())
        rotations.append(poses.rotations[0].copy())
        characters.advance()
    return Clip("played", bank.skeleton, rate, np.array(positions, np.float64), np.array(rotations, np.float64))


@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0])
@pytest.mark.parametrize("gait", GAITS)
def test_phases_of_a_cycle_grow_evenly_and_by_whole_strides(gait: str, rate: float) -> None:
    for quarter, open_end in product(range(4), (False, True)):
        clip = cut(gait, rate=rate, start=quarter / 4.0, open_end=open_end)
        looped, period = loop(clip, ROLES, find_baseline(clip, ROLES)), round(seconds_of(gait) * rate)
        assert (looped.period, looped.seamed.strides) == (period, 1)
        phase = looped.seamed.phase
        np.testing.assert_allclose(phase[period:], phase[: len(phase) - period] + 1.0, atol=1e-12)
        np.testing.assert_allclose(np.diff(phase) * period, 1.0, atol=0.05)  # of its arms, two harmonics are compared
        assert 0.0 <= phase[0] < 1.0
        np.testing.assert_array_equal(looped.alignment.phase, phase[: clip.frame_count])


@pytest.mark.parametrize("name", CYCLES)
def test_the_seam_of_a_cycle_is_its_first_frames_again(name: str) -> None:
    clip = CYCLES[name]
    looped = loop(clip, ROLES, RING)
    seam = looped.seamed.clip.frames(clip.frame_count, looped.seamed.clip.frame_count)
    again = clip.frames(clip.frame_count - looped.period, clip.frame_count)
    assert quaternion.angle(seam.rotations[:, 1:], again.rotations[: seam.frame_count, 1:]).max() < 0.01
    np.testing.assert_array_equal(looped.seamed.clip.root_positions[: clip.frame_count], clip.root_positions)


@pytest.mark.parametrize("period", [15, 20])
def test_a_cycle_that_takes_no_whole_strides_loops_like_any_clip(period: int) -> None:
    """A leg that swings once in 0.5 or 0.67 s takes 0.4 or 0.8 strides of a walk."""
    bend = 0.5 * np.sin(np.linspace(0.0, 2.0 * np.pi, period + 1))
    still = cut("walk").frames(0, 1)
    rotations = np.repeat(still.rotations, len(bend), axis=0)
    turns = quaternion.about([1.0, 0.0, 0.0], bend)
    rotations[:, ROLES.left_hip] = quaternion.multiply(rotations[:, ROLES.left_hip], turns)
    clip = replace(still, root_positions=np.repeat(still.root_positions, len(bend), axis=0), rotations=rotations)
    assert find_period(clip, ROLES) == period
    looped = loop(clip, ROLES, RING)
    assert (looped.period, looped.seamed.strides, looped.rows) == (0, 0, slice(0, period + 1))


def jolts(clip: Clip, joints: list[int]) -> float:
    """Returns the largest acceleration of joints relative to the root, m/s^2."""
    positions = joint_positions(clip)
    relative = (positions - positions[:, :1])[:, joints]
    return float(np.linalg.norm(np.diff(relative, n=2, axis=0), axis=-1).max() * clip.rate**2)


@pytest.mark.parametrize("name", CYCLES)
def test_a_cycle_plays_on_without_a_jump(cycles: Bank, name: str) -> None:
    entry = cycles.clip(name)
    assert (entry.loop, entry.gait, entry.warnings) == (1, True, ())
    long, joints = motion_of(*SOURCES[name]).resampled(entry.rate), list(range(cycles.skeleton.joint_count))
    assert jolts(played(cycles, name, rate=entry.rate), joints) < 1.2 * jolts(long, joints)


@pytest.mark.parametrize("name", CYCLES)
def test_feet_stand_in_the_seam_of_a_cycle_as_at_its_start(cycles: Bank, name: str) -> None:
    entry, period = cycles.clip(name), round(seconds_of(SOURCES[name][0]) * CYCLES[name].rate)
    standing = cycles.tables["contacts"][entry.first_row : entry.first_row + entry.row_count]
    np.testing.assert_array_equal(standing[period:], standing[: len(standing) - period])


@pytest.mark.parametrize("posture", ["relative", "absolute"])
@pytest.mark.parametrize("locomotion", ["closed", "open", "run"])
@pytest.mark.parametrize("action", ACTIONS)
def test_an_action_of_one_cycle_repeats_as_smoothly_as_a_long_one(
    cycles: Bank, action: str, locomotion: str, posture: Posture
) -> None:
    upper = list(cycles.skeleton.subtree(cycles.roles.pelvis))
    repeated, long = (jolts(played(cycles, locomotion, name, posture), upper) for name in (action, f"long_{action}"))
    assert repeated < 1.2 * long


def test_root_motion_goes_on_at_the_speed_of_the_walk(cycles: Bank) -> None:
    for name, gait in (("closed", "walk"), ("open", "walk"), ("run", "run")):
        whole, moved = motion_of(gait), played(cycles, name).root_positions[:, [0, 2]]
        speed = np.linalg.norm((whole.root_positions[-1] - whole.root_positions[0])[[0, 2]]) / whole.duration
        steps = np.linalg.norm(np.diff(moved, axis=0), axis=1) * 60.0
        assert np.linalg.norm(moved[-1] - moved[0]) / (len(moved) - 1) * 60.0 == pytest.approx(speed, rel=0.03)
        own = np.linalg.norm(np.diff(whole.root_positions[:, [0, 2]], axis=0), axis=1) * whole.rate
        assert 0.9 * own.min() < steps.min()
        assert steps.max() < 1.1 * own.max()


def test_a_cycle_in_place_does_not_wander(cycles: Bank) -> None:
    moved = played(cycles, "run_in_place").root_positions
    period = round(60.0 * CYCLES["run_in_place"].frame_count / 30.0)
    np.testing.assert_allclose(moved[10 * period :], moved[: -10 * period], atol=0.001)
