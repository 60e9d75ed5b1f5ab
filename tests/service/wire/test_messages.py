from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.service.wire import messages
from motionsplice.service.wire.encoding import Arrays
from motionsplice.service.wire.messages import json, json_pieces


@pytest.mark.parametrize("numbers", [1, 7, 64])
@given(count=st.integers(0, 40), width=st.integers(1, 5), fields=st.sampled_from([{}, {"frame": 3}]))
def test_pieces_of_json_are_the_whole_and_none_is_long(
    numbers: int, count: int, width: int, fields: dict[str, int]
) -> None:
    arrays: Arrays = {
        "root_positions": np.arange(3.0 * count, dtype=np.float32).reshape(count, 3),
        "rotations": np.arange(4 * width * count, dtype=np.int16).reshape(count, width, 4)[::-1],
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(messages, "JSON_NUMBERS", numbers)
        pieces = list(json_pieces("abc", fields, arrays))
    assert b"".join(pieces) == json("abc", fields, arrays)
    most = max(numbers, 4 * width)
    assert max(piece.count(b",") for piece in pieces) <= most + len(arrays) + 2
