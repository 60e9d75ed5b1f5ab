from __future__ import annotations

from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.errors import SettingsError
from motionsplice.sending.schedule import Schedule


@dataclass
class Clock:
    """A clock that moves on only when somebody sleeps or works; sleep takes longer than asked by `overslept`."""

    now: float = 100.0
    overslept: float = 0.0

    def time(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.now += seconds + self.overslept


def schedule(clock: Clock, rate: float, seconds: float | None) -> Schedule:
    return Schedule(rate, seconds, clock=clock.time, sleep=clock.sleep)


def test_frames_are_due_at_multiples_of_the_period_however_long_each_takes() -> None:
    clock, times = Clock(overslept=0.001), []
    for number in schedule(clock, 60.0, 2.0):
        times.append(clock.now - 100.0 - number / 60.0)
        clock.now += 0.008
    assert len(times) == 121
    assert times[0] == 0.0
    assert all(abs(late - 0.001) < 1e-9 for late in times[1:])  # and no more at the end than at the start


@given(
    st.floats(1.0, 240.0), st.floats(0.0, 3.0), st.floats(0.0, 0.01), st.lists(st.floats(0.0, 0.5), min_size=1)
)  # fmt: skip
def test_no_frame_comes_early_or_a_period_late(
    rate: float, seconds: float, overslept: float, work: list[float]
) -> None:
    clock, before = Clock(overslept=overslept), -1
    frames, last = schedule(clock, rate, seconds), int(seconds * rate + 1e-6)
    for made, number in enumerate(frames):
        assert before < number <= last
        late = clock.now - 100.0 - number / rate
        assert late > -1e-9
        assert late < 1.0 / rate + 1e-9 or number == last
        before = number
        clock.now += work[made % len(work)]
    assert before == last
    assert frames.made + frames.left_out == last + 1


def test_a_pause_leaves_frames_out_and_is_counted() -> None:
    clock, numbers = Clock(), []
    frames = schedule(clock, 10.0, 2.0)
    for number in frames:
        numbers.append(number)
        clock.now += 0.55 if number == 4 else 0.01
    assert numbers == [0, 1, 2, 3, 4, 9, *range(10, 21)]
    assert (frames.made, frames.left_out) == (17, 4)
    assert frames.latest == pytest.approx(0.05)
    assert frames.late == pytest.approx(0.05)


def test_without_an_end_it_goes_on() -> None:
    frames = iter(schedule(Clock(), 100.0, None))
    assert [next(frames) for _ in range(1000)] == list(range(1000))


def test_the_last_frame_of_a_clip_is_sent() -> None:
    """Its time in seconds times the rate may be a little below a whole number."""
    assert 0.29 * 100.0 < 29.0
    assert max(schedule(Clock(), 100.0, 0.29)) == 29


@pytest.mark.parametrize("rate", [0.0, -60.0, 0.5, 241.0, float("inf"), float("nan")])
def test_other_rates_are_refused(rate: float) -> None:
    with pytest.raises(SettingsError, match="Give 1 to 240"):
        Schedule(rate)
