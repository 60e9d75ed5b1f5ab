from __future__ import annotations

import pytest

from motion.errors import MotionError
from precompute.workers import outcomes, workers


def task(number: int) -> int:
    if number == 0:
        raise KeyboardInterrupt
    if number == 1:
        raise MemoryError
    if number == 2:
        raise ValueError("two")
    return number


@pytest.mark.parametrize("processes", [1, 2])
def test_an_error_of_our_own_fails_one_task_and_the_others_finish(processes: int) -> None:
    with workers(processes) as pool:
        made = dict(outcomes(pool, task, [1, 2, 3, 4]))
    assert (made[3], made[4]) == (3, 4)
    assert isinstance(made[1], MotionError)
    assert "not enough memory" in str(made[1])
    assert isinstance(made[2], MotionError)
    assert "an unexpected ValueError: two. This is a bug" in str(made[2])


def test_an_interrupt_ends_the_job() -> None:
    with workers(1) as pool, pytest.raises(KeyboardInterrupt):
        list(outcomes(pool, task, [0, 3]))
