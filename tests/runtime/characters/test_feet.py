"""The standing foot drives the root while locomotions are mixed."""

from __future__ import annotations

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bench.characters.feet import stances, without_feet
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from tests.naive_feet import root_step
from tests.playing import RATE, Setup, run_frames

LOCOMOTIONS = ("walk", "run", "side_step", "turn_180~mirror", "stairs_up")


@settings(max_examples=15, derandomize=True, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.permutations(LOCOMOTIONS),
    st.floats(0.0, 1.5),
    st.floats(0.1, 0.5),
    st.sampled_from(sorted(col.CURVES)),
    st.floats(0.0, 1.0),
)
def test_the_step_of_the_root_is_that_of_the_twin(
    bank: Bank, one: Setup, order: list[str], time: float, blend: float, curve: col.Curve, weight: float
) -> None:
    """Fades of one locomotion into a mix of two; from the frame before the first until one after the last."""
    characters = one()
    characters.add(1, order[0], time=time)
    run_frames(characters, 10)
    characters.play([0], {order[1]: weight, order[2]: 1.0 - weight}, time=time, blend=blend, curve=curve)
    for _ in range(round(blend * RATE) + 2):
        before = characters.state[0].copy()
        characters.advance()
        np.testing.assert_allclose(
            characters.deltas[0, :3], root_step(bank, before, characters.state[0], 1.0 / RATE), rtol=0.0, atol=1e-6
        )


def bare(characters: Characters) -> Characters:
    """Returns characters whose feet do not drive the root."""
    return Characters(without_feet(characters.stage), RATE)


def test_a_standing_foot_hardly_slides_while_the_locomotion_changes(one: Setup) -> None:
    slides = []
    for characters in (one(), bare(one())):
        for time in np.linspace(0.0, 1.0, 8, endpoint=False):
            characters.add(1, "walk", time=time)

        def change(frame: int, characters: Characters = characters) -> None:
            if frame == 30:
                characters.play(slice(None), "run")

        slides.append([one.slide for one in stances(characters, 80, change) if one.first < 47 and one.end > 31])
    assert np.median(slides[0]) < 0.015
    assert np.median(slides[1]) > 0.04
    assert max(slides[0]) < 0.5 * max(slides[1])


def test_a_locomotion_alone_does_not_read_its_feet(one: Setup) -> None:
    plain, undriven = one(), bare(one())
    for characters in (plain, undriven):
        characters.add(1, "turn_180")
        run_frames(characters, 400)
    np.testing.assert_array_equal(plain.state, undriven.state)


def test_steps_too_long_for_a_stance_are_the_clips_alone(one: Setup) -> None:
    plain, undriven = one(), bare(one())
    for characters in (plain, undriven):
        characters.add(1, {"walk": 1.0, "run": 1.0})
        characters.advance(12)
    np.testing.assert_array_equal(plain.state, undriven.state)
    for characters in (plain, undriven):
        characters.advance(1)
    assert (plain.state != undriven.state).any()


def test_the_places_of_a_character_are_the_sum_of_its_deltas(one: Setup) -> None:
    """On a straight line, so that nothing turns."""
    characters, total = one(), np.zeros(3)
    characters.add(1, "walk")
    characters.play([0], "run", blend=0.5)
    for _ in range(60):
        characters.advance()
        turn = characters.state[0, col.HEADING] - characters.deltas[0, 3]
        sine, cosine = np.sin(turn), np.cos(turn)
        x, y, z = characters.deltas[0, :3]
        total += [cosine * x + sine * z, y, cosine * z - sine * x]
    np.testing.assert_allclose(characters.state[0, col.PLACE : col.PLACE + 3], total, atol=1e-12)
