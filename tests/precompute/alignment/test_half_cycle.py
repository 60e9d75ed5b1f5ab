from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from motionsplice.motion.pointcloud import level
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.alignment.half_cycle import symmetric_phases


def ring(name: str) -> Floats:
    clip = make(name, seed=1, seconds=4.0)
    return level(find_baseline(clip, find_roles(clip.skeleton)).clouds)


def at_places(clouds: Floats, places: Floats) -> Floats:
    """The ring's clouds at real-valued places in cycles."""
    closed = np.concatenate([clouds, clouds[:1]])
    return np.asarray(CubicSpline(np.linspace(0.0, 1.0, len(closed)), closed, bc_type="periodic")(places % 1.0))


def test_a_stride_with_equal_steps_keeps_even_phases() -> None:
    phases = symmetric_phases(ring("walk"))
    np.testing.assert_allclose(phases, np.linspace(0.0, 1.0, len(phases)), atol=0.01)


@pytest.mark.parametrize("name", ["walk", "run"])
@pytest.mark.parametrize("uneven", [-0.04, 0.04, 0.05])
def test_half_a_cycle_later_is_the_mirror_image_of_uneven_steps(name: str, uneven: float) -> None:
    clouds = ring(name)
    evenly = np.linspace(0.0, 1.0, 40, endpoint=False)  # time; the walk's own phase at it:
    walked = evenly + uneven * np.sin(2.0 * np.pi * evenly)
    phases = symmetric_phases(at_places(clouds, walked))
    assert np.diff(phases).min() > 0.0
    assert phases[-1] == pytest.approx(1.0)
    opposite = np.interp(walked + 0.5, np.append(walked, walked + 1.0), np.append(phases[:-1], phases[:-1] + 1.0))
    without = np.interp(walked + 0.5, np.append(walked, walked + 1.0), np.append(evenly, evenly + 1.0)) - evenly
    apart = np.abs(opposite - phases[:-1] - 0.5).max()
    assert apart < 0.03
    assert apart < 0.4 * np.abs(without - 0.5).max()


def test_a_stride_unlike_its_mirror_image_keeps_even_phases() -> None:
    phases = symmetric_phases(np.random.default_rng(0).standard_normal((30, 3, 3)))
    np.testing.assert_allclose(phases, np.linspace(0.0, 1.0, len(phases)))


def test_phases_count_laps_and_are_whole_where_the_left_foot_touches_down() -> None:
    clip = make("walk", seed=1, seconds=4.0)
    baseline = find_baseline(clip, find_roles(clip.skeleton))
    cells = len(baseline.clouds)
    np.testing.assert_allclose(baseline.phase_at(baseline.zero + cells * np.arange(-2.0, 3.0)), np.arange(-2.0, 3.0))
    assert np.diff(baseline.phase_at(np.linspace(-cells, 2 * cells, 500))).min() > 0.0
