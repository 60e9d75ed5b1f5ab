from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.kernels import evaluate as kernels
from motionsplice.runtime.kernels.in_step import action_phase, cycles_to, phase_at
from motionsplice.runtime.requests import Requests


def shown(bank: Bank, locomotion: int, time: float, action: int, cycles: int) -> float:
    """The frame of the action that kernels show."""
    requests, frames = Requests.empty(1), np.empty(1)
    requests.locomotion[:], requests.action[:], requests.cycles[:] = locomotion, action, cycles
    requests.time[:] = time
    kernels.action_frames(Evaluator(bank).arrays, requests.records, frames)
    return float(frames[0])


@given(data=st.data(), share=st.floats(0.0, 1.0), start=st.floats(0.0, 1.0))
def test_an_action_begins_at_a_moment_or_less_than_a_cycle_after(
    bank: Bank, data: st.DataObject, share: float, start: float
) -> None:
    locomotion, action = (data.draw(st.integers(0, len(bank.clips) - 1)) for _ in range(2))
    entry_l, entry_u = bank.clips[locomotion], bank.clips[action]
    arrays, time, begin = Evaluator(bank).arrays, share * entry_l.duration, start * entry_u.duration
    wanted = phase_at(arrays, action, begin)
    cycles = int(cycles_to(arrays, locomotion, time, action, wanted))
    phase = action_phase(arrays, locomotion, time, action, cycles)
    assert wanted - 0.0011 <= phase < wanted + 0.9991
    ahead = phase - phase_at(arrays, locomotion, time)
    assert ahead == pytest.approx(np.round(ahead), abs=1e-9)
    if phase <= entry_u.last_phase:
        rows = slice(entry_u.first_row, entry_u.first_row + entry_u.row_count)
        own = bank.tables["phase_of_frame"][rows]
        frame = np.interp(phase, own, np.arange(len(own)))
        assert max(0.0, shown(bank, locomotion, time, action, cycles)) == pytest.approx(frame, abs=1e-4)


def test_many_characters_are_each_of_them_alone(bank: Bank) -> None:
    arrays, draw = Evaluator(bank).arrays, np.random.default_rng(0)
    locomotion, action = draw.integers(0, len(bank.clips), (2, 50))
    time, phase = draw.uniform(-1.0, 6.0, 50), draw.uniform(0.0, 5.0, 50)
    together = cycles_to(arrays, locomotion, time, action, phase)
    alone = [int(cycles_to(arrays, *one)) for one in zip(locomotion, time, action, phase, strict=True)]
    assert together.tolist() == alone
