"""Allowances at moments that these tests choose."""

from __future__ import annotations

from contextlib import ExitStack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.service.allowance import BURST, Allowances, SharedAllowances

RATE = 1000.0


class Clock:
    """A clock that stands until it is set."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_connection_waits_for_what_exceeds_the_burst() -> None:
    with Allowances(RATE).of("a", Clock()) as allowance:
        assert allowance.charge(BURST, 0.0) == 0.0
        assert allowance.charge(500.0, 0.0) == 0.5
        assert allowance.charge(500.0, 0.5) == 0.5
        assert allowance.charge(500.0, 1.5) == 0.0
        assert allowance.charge(BURST, 11.5) == 0.0
        assert allowance.charge(1000.0, 11.5) == pytest.approx(1.0)


def test_connections_of_an_address_share_its_burst_and_others_have_their_own() -> None:
    allowances, clock = Allowances(RATE), Clock()
    with allowances.of("a", clock) as first, allowances.of("a", clock) as second, allowances.of("b", clock) as other:
        assert first.charge(BURST, 0.0) == 0.0
        assert second.charge(2000.0, 0.0) == 2.0
        assert other.charge(BURST, 0.0) == 0.0


def test_beside_a_flood_of_the_same_address_a_connection_keeps_its_own_rate() -> None:
    allowances, clock = Allowances(RATE), Clock()
    with allowances.of("a", clock) as flooding, allowances.of("a", clock) as healthy:
        flooding.charge(100.0 * BURST, 0.0)
        for tick in range(1, 600):
            assert healthy.charge(RATE / 60.0, tick / 60.0) == pytest.approx(0.0, abs=1e-9)


def test_a_client_that_connects_anew_has_no_new_burst() -> None:
    allowances, clock = Allowances(RATE), Clock()
    with allowances.of("a", clock) as allowance:
        allowance.charge(BURST, 0.0)
    clock.now = 1.0
    with allowances.of("a", clock) as allowance:
        assert allowance.charge(1500.0, 1.0) == 0.5


def test_addresses_are_forgotten_when_their_burst_is_whole_again() -> None:
    allowances, clock = Allowances(RATE), Clock()
    for number in range(100):
        with allowances.of(f"{number}", clock) as allowance:
            allowance.charge(BURST, 0.0)
    clock.now = 5.0
    with allowances.of("a", clock):
        assert len(allowances) == 101
    clock.now = BURST / RATE
    with allowances.of("b", clock):
        assert len(allowances) == 1


@pytest.mark.parametrize("connections", [1, 4])
@given(asked=st.lists(st.tuples(st.integers(0, 3), st.floats(1.0, 3000.0), st.floats(0.0, 1.0)), max_size=60))
def test_what_an_address_gets_done_is_bounded(connections: int, asked: list[tuple[int, float, float]]) -> None:
    """Connections ask, each when it may and after a pause: the burst, and what grew since, are all they get."""
    allowances, clock, done = Allowances(RATE), Clock(), 0.0
    free = [0.0] * connections
    with ExitStack() as stack:
        every = [stack.enter_context(allowances.of("a", clock)) for _ in free]
        for number, cost, pause in asked:
            one = number % connections
            clock.now = max(clock.now, free[one]) + pause
            free[one] = clock.now + every[one].charge(cost, clock.now)
            done += cost
        end = max([clock.now, *free])
        assert done <= BURST + connections * RATE * end + 1e-6


def test_all_that_an_address_asks_for_shares_its_allowance_which_begins_full() -> None:
    allowances = SharedAllowances(RATE, 3.0 * RATE)
    assert allowances.charge("a", 3.0 * RATE, 0.0) == 0.0
    assert allowances.charge("a", RATE, 0.0) == 1.0
    assert allowances.charge("b", 3.0 * RATE, 0.0) == 0.0
    assert allowances.charge("a", 2.0 * RATE, 2.0) == 1.0
    assert allowances.charge("a", 3.5 * RATE, 100.0) == 0.5


def test_addresses_whose_allowance_is_full_again_are_forgotten() -> None:
    allowances = SharedAllowances(RATE, RATE)
    for number in range(100):
        allowances.charge(f"{number}", RATE, 0.0)
    allowances.charge("a", 1.0, 0.5)
    assert len(allowances) == 101
    allowances.charge("b", 1.0, 1.5)
    assert len(allowances) == 1
