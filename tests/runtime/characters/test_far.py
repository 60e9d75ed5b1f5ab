"""Characters far from the origin, and after many turns."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.aim import Look
from motionsplice.runtime.stage import Stage
from tests import naive_character
from tests.playing import RATE, Setup, evaluated

FAR = 50_000.0  # metres: 15 hours of walking
places = st.floats(-4e6, 4e6)
shifts = st.integers(-10_000, 10_000)


def beside(stage: Stage, place: Floats, heading: float) -> Characters:
    """Returns two rebased characters: one walks, the other also waves, looks at a point nearby and locks its feet."""
    characters = Characters(stage, RATE)
    rows = characters.add(2, "walk")
    x, y, z = place.tolist()
    characters.place(rows, [x, y, z], heading)
    characters.rebase(rows)
    characters.act([1], Action("wave", blend=0.0))
    characters.look([1], Look([x + 1.0, y + 1.5, z + 2.0]), blend=0.0)
    characters.lock_feet([1])
    return characters


@given(x=places, z=places, heading=st.floats(-7.0, 7.0), shift=st.tuples(shifts, shifts, shifts))
@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_poses_relative_to_an_origin_are_the_same_at_each(
    stage: Stage, x: float, z: float, heading: float, shift: tuple[int, int, int]
) -> None:
    moved, place = 256.0 * np.array(shift), np.array([x, 0.0, z])
    here, there = beside(stage, place, heading), beside(stage, place + moved, heading)
    for _ in range(20):
        here.advance()
        there.advance()
    (ours, turns), (theirs, others) = evaluated(here), evaluated(there)
    # origins are added, for a place in the middle of two may fall to either
    np.testing.assert_allclose(here.origins + ours, there.origins - moved + theirs, atol=2e-5)
    np.testing.assert_allclose(turns, others, atol=2e-5)
    assert np.abs(ours[:, [0, 2]]).max() < 128.0 + 1.0


@pytest.mark.parametrize("in_place", [False, True])
def test_a_rebased_pose_is_that_of_the_twin(stage: Stage, in_place: bool) -> None:
    characters = beside(stage, np.array([FAR, -700.0, 3.0]), 0.5)
    characters.in_place(slice(None), in_place)
    characters.advance()
    roots, rotations = evaluated(characters)
    expected_root, expected_rotations = naive_character.pose(stage.bank, characters.state[0])
    np.testing.assert_allclose(roots[0], expected_root, atol=1e-5)
    np.testing.assert_allclose(np.abs((rotations[0] * expected_rotations).sum(axis=1)), 1.0, atol=1e-5)
    expected = [0.0, 0.0, 0.0] if in_place else [FAR - 80.0, -768.0, 0.0]
    np.testing.assert_array_equal(characters.origins, [expected, expected])


def test_only_rebased_characters_have_other_origins(one: Setup) -> None:
    characters = one()
    characters.add(3, "walk")
    characters.place(slice(None), [FAR, 0.0, 0.0])
    characters.rebase([0, 1])
    characters.rebase(1, False)
    np.testing.assert_array_equal(characters.origins[:, 0] > 0.0, [True, False, False])


def test_steps_far_from_the_origin_are_as_smooth_as_near_it(one: Setup) -> None:
    """Without an origin, float32 moves a root by 4 mm at once."""
    characters = one()
    rows = characters.add(3, "walk")
    characters.place(rows[1:], [FAR, 0.0, FAR])
    characters.rebase(rows[2])
    roots = []
    for _ in range(60):
        roots.append(evaluated(characters)[0] + characters.origins)
        characters.advance()
    jerks = np.abs(np.diff(roots, 2, axis=0)).max(axis=(0, 2))
    assert jerks[1] > jerks[0] + 2e-3
    assert jerks[2] == pytest.approx(jerks[0], abs=5e-5)


def test_a_heading_stays_within_two_turns_and_rotations_keep_their_sign(one: Setup) -> None:
    characters = one()
    characters.add(2, "turn_180")
    for row, side in enumerate([-1.0, 1.0]):
        characters.place([row], [0.0, 0.0, 0.0], side * (4.0 * np.pi - 0.5))
    headings, turns = [], []
    for _ in range(900):
        characters.advance()
        headings.append(characters.state[:, col.HEADING].copy())
        turns.append(evaluated(characters)[1][:, 0])
    assert np.abs(headings).max() <= 4.0 * np.pi
    assert np.abs(np.diff(headings, axis=0)).max() == pytest.approx(4.0 * np.pi, abs=0.2)  # one of them wraps
    assert (np.array(turns[:-1]) * turns[1:]).sum(axis=2).min() > 0.9
