"""Arrays of MessagePack messages begin at multiples of 4 bytes, and decoders accept the heads that achieve it."""

from __future__ import annotations

import string
from unittest import mock

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.service.characters.frame_format import FrameFormat
from motionsplice.service.wire.encoding import Encoding
from motionsplice.service.wire.messages import packed
from tests.service.messages import blob_offsets

BANK = "b6093d240d320be34211b036cccaa68d"
sizes = st.integers(0, 5) | st.sampled_from([255, 256, 1000, 5500])
names = st.text(string.ascii_lowercase, min_size=1, max_size=20)
values = st.integers(0, 2**63) | st.floats(allow_nan=False) | st.text(max_size=40) | st.booleans()


@given(
    n=sizes,
    count=st.integers(1, 3),
    joints=st.integers(1, 60),
    numbers=st.sampled_from(["float32", "int16"]),
    parts=st.sampled_from(["local", "world", "both"]),
    deltas=st.booleans(),
    origins=st.booleans(),
    first=st.integers(0, 2**40),
)
def test_frames_of_characters_are_aligned(
    n: int, count: int, joints: int, numbers: str, parts: str, deltas: bool, origins: bool, first: int
) -> None:
    form = FrameFormat(Encoding(numbers=numbers, parts=parts), deltas, origins)
    draw = np.random.default_rng(n)
    arrays = {"root_positions": draw.random((n, 3), np.float32)}
    if parts != "world":
        arrays["rotations"] = draw.random((n, joints, 4), np.float32).astype(np.dtype(numbers))
    if parts != "local":
        arrays["world_positions"] = draw.random((n, joints, 3), np.float32)
    characters = mock.Mock(deltas=draw.random((n, 4)), origins=draw.random((n, 3)))
    motion = form.motion(characters)
    assert len(motion) == 2 * deltas + origins
    ids = np.arange(n, dtype=np.uint32)
    message = form.writer(BANK, 60.0, count * [{**motion, **arrays}])(first, 1.5e9, ids, 0, n)
    offsets = blob_offsets(message)
    assert [offset % 4 for offset in offsets.values()] == len(offsets) * [0]
    assert len(offsets) == 1 + len(motion) + len(arrays)
    fields = msgpack.unpackb(message)
    assert {name: fields[name] for name in ("bank", "frame", "count", "rate", "time")} == {
        "bank": BANK, "frame": first, "count": count, "rate": 60.0, "time": 1.5e9,
    }  # fmt: skip
    for name, array in {**motion, **arrays}.items():
        assert fields[name] == count * array.tobytes()
    assert fields["ids"] == ids.tobytes()


@given(fields=st.dictionaries(names, values, max_size=6), first=names, last=names)
def test_messages_with_any_fields_and_two_arrays_are_aligned(fields: dict[str, object], first: str, last: str) -> None:
    arrays = {name: np.arange(3, dtype=np.float32) for name in (f"a{first}", f"b{last}")}
    fields = {name: value for name, value in fields.items() if name not in {*arrays, "bank"}}
    message = packed(BANK, fields, arrays)
    assert [offset % 4 for offset in blob_offsets(message).values()] == [0, 0]
    assert msgpack.unpackb(message) == {**fields, "bank": BANK, **{name: one.tobytes() for name, one in arrays.items()}}


@pytest.mark.parametrize("fields", range(4))
def test_the_heads_are_the_forms_that_the_protocol_lists(fields: int) -> None:
    """A map is fixmap or map 16, a key fixstr, str 8 or str 16, and a blob bin 32: clients may decode no others."""
    array = np.zeros(1, np.float32)
    message = packed(BANK, {"x" * fields: 1}, {"ids": array, "root_positions": array, "world_positions": array})
    assert message[0] in (0x85, 0xDE)
    for name, offset in blob_offsets(message).items():
        assert message[offset - 5] == 0xC6
        before = message[: offset - 5].removesuffix(name.encode())
        size = len(name)
        heads = [bytes((0xA0 | size,)), bytes((0xD9, size)), bytes((0xDA, 0, size))]
        assert any(before.endswith(head) for head in heads)
