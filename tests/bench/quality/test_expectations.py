from __future__ import annotations

import numpy as np

from bench.quality.expectations import compared


def test_equal_orders_correlate_and_warnings_are_counted_by_what_is_true() -> None:
    replaced = np.array([0.1, 0.11, 0.12, 0.13])
    ratio, true_ratio = np.array([0.2, 0.5, 0.85, 0.95]), np.array([0.1, 0.4, 0.5, 0.9])
    found = compared(np.column_stack([ratio * replaced, replaced, true_ratio * replaced, replaced]))
    assert [value for _, value, _ in found.rows] == ["1.00", "1.00", "1.00", "1", "1"]
