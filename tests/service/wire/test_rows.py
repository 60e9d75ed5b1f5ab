"""Messages of some rows of arrays, against those of `packed`."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.service.wire.messages import packed
from motionsplice.service.wire.rows import RowMessages

BANK = "b6093d240d320be34211b036cccaa68d"


@given(
    sizes=st.lists(st.integers(0, 3) | st.just(300), min_size=1, max_size=6),
    count=st.integers(1, 3),
    joints=st.integers(1, 60),
    kind=st.sampled_from([np.float32, np.int16]),
    rate=st.floats(1.0, 1000.0),
    firsts=st.lists(st.integers(0, 2**40) | st.integers(0, 300), min_size=6, max_size=6),
    time=st.floats(0.0, 2e9),
)
def test_messages_have_the_bytes_of_packed(
    sizes: list[int], count: int, joints: int, kind: type, rate: float, firsts: list[int], time: float
) -> None:
    n, draw = sum(sizes), np.random.default_rng(joints)
    frames = [
        {
            "root_positions": draw.random((n, 3), np.float32),
            "root_turns": draw.random(n, np.float32),
            "rotations": (100 * draw.random((n, joints, 4))).astype(kind),
        }
        for _ in range(count)
    ]
    ids = draw.integers(0, 2**32, n, dtype=np.uint32)
    messages, row = RowMessages(BANK, rate, frames), 0
    for first, size in zip(firsts, sizes, strict=False):
        rows = slice(row, row + size)
        fields = {"frame": first, "count": count, "rate": rate, "time": time}
        stacked = {name: np.stack([frame[name][rows] for frame in frames]) for name in frames[0]}
        expected = packed(BANK, fields, {"ids": ids[rows], **stacked})
        assert messages.message(first, time, ids[rows], row, row + size) == expected
        row += size
