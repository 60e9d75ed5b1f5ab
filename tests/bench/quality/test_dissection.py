from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.quality.aligned_truth import aligned_truth
from bench.quality.dissection import best_time, dissect
from bench.quality.measures import upper_body_errors
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.splice import attach
from tests.conftest import CLIPS

WALK = CLIPS["walk"]
ROLES = find_roles(WALK.skeleton)
NOW = np.arange(float(WALK.frame_count))


def with_upper_body(clip: Clip, frames: Floats) -> Clip:
    """Returns the walk with the upper body that `clip` has at these frames."""
    still = np.broadcast_to(quaternion.IDENTITY, (len(frames), 4))
    return attach(WALK, clip.sampled(frames)[1], still, ROLES)


def parts_of(result: Clip, truth: Clip, frames: Floats) -> dict[str, float]:
    none = np.tile(quaternion.IDENTITY, (WALK.frame_count, 1))
    found = dissect(result, WALK, WALK, truth, (none, none), frames, WALK.frame_count, ROLES)
    return vars(found)


def test_nothing_is_lacking_of_a_splice_that_is_its_truth() -> None:
    parts = parts_of(WALK, WALK, NOW)
    assert parts["lag_seconds"] == 0.0
    assert max(parts.values()) < 1e-4


def test_a_constant_lag_is_found_and_so_is_a_uneven_one() -> None:
    late = np.clip(NOW - 6.0, 0.0, NOW[-1])
    result = with_upper_body(WALK, late)
    error = 100.0 * upper_body_errors(result, WALK, ROLES).mean()
    parts = parts_of(result, WALK, late)
    assert parts["lag_seconds"] == pytest.approx(6.0 / WALK.rate)
    assert parts["lag"] < 0.1 * error
    assert parts["time"] <= parts["lag"]
    uneven = NOW - 6.0 * np.sin(np.pi * NOW / NOW[-1]) ** 2
    parts = parts_of(with_upper_body(WALK, uneven), WALK, uneven)
    assert parts["time"] < 0.2 * parts["lag"]


def test_a_turned_torso_is_found() -> None:
    rotations = WALK.rotations.copy()
    leaning = quaternion.about([1.0, 0.0, 0.0], 0.2)
    rotations[:, ROLES.pelvis] = quaternion.multiply(rotations[:, ROLES.pelvis], leaning)
    result = replace(WALK, rotations=rotations)
    assert upper_body_errors(result, WALK, ROLES).mean() > 0.02
    assert parts_of(result, WALK, NOW)["torso"] < 1e-4


@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_the_best_time_is_the_least_over_all_paths(seed: int, most: int) -> None:
    draw = np.random.default_rng(seed)
    grid, jumps = draw.uniform(size=(5, 4)), draw.uniform(size=4) < 0.3

    def least(row: int, column: int) -> float:
        if row == 4:
            return float(grid[row, column])
        onward = range(4) if jumps[row] else range(column, min(column + most, 3) + 1)
        return float(grid[row, column]) + min(least(row + 1, after) for after in onward)

    assert best_time(grid, jumps, most) == pytest.approx(min(least(0, column) for column in range(4)) / 5.0)


def test_another_take_is_aligned_by_its_legs() -> None:
    curve, other = make("curve", "wave", seconds=4.0, seed=3), make("walk", "wave", seconds=6.0, seed=4)
    truth = aligned_truth(curve, other, ROLES)
    assert truth.rate == curve.rate
    wanted = curve.frames(0, truth.frame_count)
    assert upper_body_errors(truth, wanted, ROLES).mean() < 0.3 * upper_body_errors(other, wanted, ROLES).mean()
