from __future__ import annotations

import tracemalloc
from pathlib import Path

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.errors import BankError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.bounded import unpacked
from motionsplice.runtime.format.manifest import FORMAT, MANIFEST, VERSION, content_digest

SIZE = 2**21
values = st.recursive(
    st.none() | st.integers(-(2**63), 2**63) | st.floats(allow_nan=False) | st.text() | st.binary(),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(), inner, max_size=5),
    max_leaves=30,
)


@given(values)
def test_small_documents_come_back_as_they_were(document: object) -> None:
    assert unpacked(msgpack.packb(document)) == document


@pytest.mark.parametrize("piece", [b"\x80", b"\x90", b"\x91\x80", b"\x81\xa0\x90"])
@pytest.mark.parametrize("inside", [True, False])
def test_a_manifest_of_nothing_but_empty_maps_takes_little_memory(tmp_path: Path, piece: bytes, inside: bool) -> None:
    count = SIZE // len(piece)
    packed = b"\xdd" + count.to_bytes(4, "big") + piece * count
    outer = {"format": FORMAT, "version": VERSION, "digest": content_digest(packed), "body": packed}
    (tmp_path / MANIFEST).write_bytes(msgpack.packb(outer) if inside else packed)
    tracemalloc.start()
    try:
        with pytest.raises(BankError):
            Bank.open(tmp_path)
        assert tracemalloc.get_traced_memory()[1] < 30 * SIZE
    finally:
        tracemalloc.stop()
