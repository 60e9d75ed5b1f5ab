from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels import evaluate as kernels
from motionsplice.runtime.kernels.lookup import IN_STEP
from motionsplice.runtime.requests import Requests
from motionsplice.runtime.simd.handle import handle_of


def action_frame(bank: Bank, locomotion: int, time: float, action: int, cycles: int) -> float:
    """Returns the frame of the action that kernels play."""
    requests, frames = Requests.empty(1), np.empty(1)
    requests.locomotion[:], requests.action[:], requests.cycles[:] = locomotion, action, cycles
    requests.time[:] = time
    bank_arrays = arrays.bank_arrays(bank)
    handle = handle_of(arrays.SpliceArrays(bank_arrays, arrays.scratch(bank_arrays, 1)))
    kernels.action_frames(handle, requests.records, frames)
    return float(frames[0])


@given(data=st.data(), share=st.floats(0.0, 1.0), start=st.floats(0.0, 1.0))
def test_cycles_move_an_action_to_a_moment_in_step(bank: Bank, data: st.DataObject, share: float, start: float) -> None:
    locomotion, action = (data.draw(st.integers(0, len(bank.clips) - 1)) for _ in range(2))
    entry_l, entry_u = bank.clips[locomotion], bank.clips[action]
    time = share * entry_l.duration
    phase_l, wanted = bank.phase_at(entry_l.name, time), bank.phase_at(entry_u.name, start * entry_u.duration)
    first = math.ceil(entry_u.first_phase - entry_l.first_phase - IN_STEP)  # cycles if both begin together
    cycles = math.ceil(wanted - phase_l - IN_STEP) - first
    phase = phase_l + first + cycles
    assert wanted - 0.0011 <= phase < wanted + 0.9991
    if phase <= entry_u.last_phase:
        rows = slice(entry_u.first_row, entry_u.first_row + entry_u.row_count)
        own = bank.tables["phase_of_frame"][rows]
        frame = np.interp(phase, own, np.arange(len(own)))
        assert max(0.0, action_frame(bank, locomotion, time, action, cycles)) == pytest.approx(frame, abs=1e-4)


@given(data=st.data(), seconds=st.floats(-1.0, 20.0))
def test_the_phase_at_a_time_is_interpolated_between_frames(bank: Bank, data: st.DataObject, seconds: float) -> None:
    clip = data.draw(st.sampled_from(bank.clips))
    phase = bank.phase(clip.name)
    wanted = np.interp(seconds * clip.rate, np.arange(len(phase)), phase)
    assert bank.phase_at(clip.name, seconds) == pytest.approx(wanted, abs=1e-12)
