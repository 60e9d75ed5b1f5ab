from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.quality.interpolation import loss_of, losses
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats


def turning(radians: Floats) -> Clip:
    """A rig whose root stays at the origin and turns by `radians` [F] about Y at 120 Hz."""
    walk = make("walk", seconds=0.0)
    rotations = np.tile(quaternion.IDENTITY, (len(radians), walk.skeleton.joint_count, 1))
    rotations[:, 0] = quaternion.about([0.0, 1.0, 0.0], radians)
    return replace(walk, rate=120.0, root_positions=np.zeros((len(radians), 3)), rotations=rotations)


def test_an_even_turn_is_interpolated_exactly() -> None:
    loss = loss_of(turning(np.linspace(0.0, 2.0, 41)), step=4, rate=30.0)
    assert loss.worst_turn < 1e-7
    assert loss.worst < 1e-7


def test_the_error_of_an_accelerating_turn_is_the_sagitta() -> None:
    clip = turning(0.001 * np.arange(41.0) ** 2)
    for step in (2, 4):
        # at its middle, a chord is its coefficient times (step / 2)^2 above the parabola
        assert loss_of(clip, step, 120.0 / step).worst_turn == pytest.approx(0.001 * (step / 2) ** 2, abs=1e-6)


def test_a_clip_is_judged_at_lower_rates_that_divide_its_own() -> None:
    clip = turning(np.linspace(0.0, 1.0, 41))
    assert [loss.rate for loss in losses(clip)] == [30.0, 60.0]
    with pytest.raises(ClipError, match="not a multiple of 30, 60, 120 Hz"):
        losses(replace(clip, rate=50.0))


def test_twice_the_keys_reduce_the_error_to_a_quarter() -> None:
    coarse, fine, finest = losses(make("walk", seconds=3.0, rate=960.0))
    assert coarse.mean / fine.mean == pytest.approx(4.0, rel=0.1)
    assert fine.mean / finest.mean == pytest.approx(4.0, rel=0.1)
