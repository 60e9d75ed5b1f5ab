from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.formats import bvh
from motionsplice.motion.procedural.library import make
from motionsplice.motion.rates import CLOSE, RATES, meant_rate

WALK = make("walk", seconds=0.2)


@pytest.mark.parametrize(
    ("step", "rate"),
    [
        ("0.0333333000", 30.0),
        ("0.033333335", 30.0),
        ("0.03333333507180214", 30.0),
        ("0.033", 30.0),
        ("0.034", 30.0),
        ("0.03", 30.0),
        ("0.0334", 30.0 / 1.001),
        ("0.033367", 30.0 / 1.001),
        ("0.017", 60.0),
        ("0.016", 60.0),
        ("0.016667", 60.0),
        ("0.0166833", 60.0 / 1.001),
        ("0.008342", 120.0 / 1.001),
        ("0.0083", 120.0),
        ("0.008", 120.0),
        ("0.004167", 240.0),
        ("0.042", 24.0),
        ("0.041708", 24.0 / 1.001),
        ("0.04", 25.0),
        ("0.0208", 48.0),
        ("0.02", 50.0),
        ("0.01", 100.0),
        ("0.016949", 59.0),
        ("0.016949152573943138", 59.0),
        ("0.008000", 125.0),
        ("0.004000", 250.0),
        ("0.005", 200.0),
        ("0.05", 20.0),
        ("0.1", 10.0),
        ("1", 1.0),
        ("0.0127123", 1.0 / 0.0127123),
    ],
)
def test_the_digits_of_a_frame_time_mean_a_rate(step: str, rate: float) -> None:
    assert meant_rate(step) == pytest.approx(rate, rel=1e-12)


@given(st.sampled_from(RATES), st.integers(5, 12), st.booleans())
def test_common_rates_are_found_whether_rounded_or_truncated(rate: float, decimals: int, truncated: bool) -> None:
    step = 1.0 / rate
    text = f"{np.floor(step * 10**decimals) / 10**decimals if truncated else step:.{decimals}f}"
    near = [other for other in RATES if abs(1.0 / other - float(text)) < 10.0**-decimals]
    assert meant_rate(text) == rate or len(near) > 1


@given(st.integers(1, 2000).map(float) | st.sampled_from(RATES) | st.floats(0.51, 2000.0))
def test_a_written_file_has_the_same_rate(rate: float) -> None:
    again = bvh.parse(bvh.dump_bvh(replace(WALK, rate=rate))).rate
    if rate in RATES or rate == round(rate):
        assert again == rate
    else:  # a rate within CLOSE of a common one is read as that
        assert again == pytest.approx(rate, rel=1e-8 if again not in RATES else CLOSE)


@pytest.mark.parametrize(("step", "noted"), [("0.017", True), ("0.0333333", False), ("0.008342", False)])
def test_a_rate_that_differs_from_the_digits_is_noted(step: str, noted: bool) -> None:
    lines = [
        f"Frame Time: {step}" if line.startswith("Frame T") else line
        for line in bvh.dump_bvh(WALK).decode().splitlines()
    ]
    notes = bvh.parse("\n".join(lines).encode()).notes
    assert any(f"a frame time of {step} s was read as 60 frames per second" in note for note in notes) == noted
