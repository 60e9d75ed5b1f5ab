from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.formats.decimals import as_bytes, read_table

FORMS = ("{:.6f}", "{:+.3f}", "{:g}", "{:.9g}", "{:.4e}", "{:.15g}")


def twin(text: str) -> list[list[float]]:
    return [[float(word) for word in line.split()] for line in text.splitlines() if line.strip()]


@given(st.lists(st.floats(-1e6, 1e6), min_size=6, max_size=6), st.sampled_from(FORMS))
def test_numbers_as_files_write_them_equal_float(numbers: list[float], form: str) -> None:
    words = [form.format(0.0 if 0.0 < abs(number) < 1e-7 else number) for number in numbers]
    text = f" {words[0]}\t{words[1]} {words[2]} \n\n{words[3]} {words[4]}  {words[5]}"
    values = read_table(as_bytes(text), 2, 3)
    assert values is not None
    np.testing.assert_array_equal(values, twin(text))


@given(st.lists(st.floats(-1e300, 1e300), min_size=4, max_size=4))
def test_any_other_number_agrees_to_14_digits(numbers: list[float]) -> None:
    text = " ".join("0" if 0.0 < abs(number) < 1e-290 else repr(number) for number in numbers)
    values = read_table(as_bytes(text), 1, 4)
    assert values is not None
    np.testing.assert_allclose(values, twin(text), rtol=1e-14)


@pytest.mark.parametrize(
    "text",
    ["1 2", "1 2 3 4", "1 2\n3", "1 2 x", "1 2 3x", "1 2 .", "1 2 -", "1 2 1e", "1 2 1.2.3", "1 2 nan", "1 2 inf",
     "1 2 1e999", "1 2 0x1", "1 2 1_0", "1 2 ٣", "", "1 2 3\n1 2 3"],
)  # fmt: skip
def test_anything_but_a_row_of_three_finite_numbers_gives_none(text: str) -> None:
    assert read_table(as_bytes(text), 1, 3) is None


def test_no_memory_is_allocated_for_missing_numbers() -> None:
    assert read_table(as_bytes("1 2 3"), 10**9, 10**6) is None
