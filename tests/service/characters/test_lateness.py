"""Which frames are left out, by a clock that only these tests move."""

from __future__ import annotations

from itertools import pairwise

import pytest

from motionsplice.service.characters.lateness import FEW, Lateness, frames_at_once, moved

START, RATES = 1000.0, (60.0, 30.0, 50.0)


def frames(costs: list[float], rate: float = 60.0) -> tuple[list[int], list[float]]:
    """Returns the numbers of the frames that a clock makes whose ticks take `costs` seconds, and how late each is."""
    clock, now, next_frame = Lateness(), START, 0
    made, late = [], []
    for cost in costs:
        due = START + next_frame / rate
        if due > now:
            clock.end()
            now = due
        clock.begin(now - due)
        next_frame += clock.missed(due, rate, now)
        made.append(next_frame)
        late.append(now - START - next_frame / rate)
        next_frame += 1
        now += cost
    return made, late


def test_a_clock_that_is_on_time_makes_all_frames() -> None:
    made, late = frames(100 * [0.016])
    assert made == list(range(100))
    assert max(late) < 1e-9


def test_one_long_tick_is_made_up_for() -> None:
    made, late = frames([0.001, 0.09, *50 * [0.001]])
    assert made == list(range(52))
    assert max(late) < 0.1
    assert late[-1] < 1e-9


def test_a_clock_that_was_too_late_once_goes_on_with_the_newest_frame() -> None:
    made, late = frames([0.001, 0.5, *50 * [0.001]])
    assert made[:2] == [0, 1]
    assert made[2:] == list(range(31, 81))  # 0.5 s after frame 1
    assert max(late[2:]) < 1 / 60


@pytest.mark.parametrize("times", [1.1, 1.5, 2.0, 3.3, 9.0])
def test_with_too_much_work_it_makes_as_many_frames_as_it_can_evenly(times: float) -> None:
    made, late = frames(200 * [times / 60.0])
    steps = [after - before for before, after in pairwise(made)]
    settled = next(number for number, step in enumerate(steps) if step > 1) + 1
    assert settled < 100
    assert {step - int(times) for step in steps[settled:]} <= {0, 1}
    assert sum(steps[settled:]) == pytest.approx(times * len(steps[settled:]), abs=1.0)
    assert max(late[settled + 1 :]) < 1 / 60 + 1e-9


def test_it_makes_all_frames_again_when_there_is_less_work() -> None:
    made, _ = frames([*50 * [0.04], *50 * [0.01]])
    assert made[52:] == list(range(made[52], made[52] + 48))


@pytest.mark.parametrize("rate", RATES)
def test_when_it_sheds_each_rate_has_its_newest_frame(rate: float) -> None:
    clock = Lateness()
    assert clock.missed(START, rate, START + 0.09) == 0
    clock.begin(0.11)
    assert clock.missed(START, rate, START + 0.09) == int(0.09 * rate)
    assert clock.missed(START + 1.0, rate, START) == 0


def test_characters_move_on_for_a_second_at_most() -> None:
    assert moved(59, 60.0) == 59
    assert moved(1000, 60.0) == 60
    assert moved(1000, 0.5) == 1


def test_long_steps_are_taken_when_all_connections_together_miss_too_much() -> None:
    assert frames_at_once(FEW, 60.0) == 1
    assert frames_at_once(FEW + 1, 60.0) == 6
