"""Names that come twice in a file."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.formats.names import numbered


@given(st.lists(st.sampled_from(["a", "b", "a.001", "b.001", "a.002"]), max_size=12))
def test_all_names_differ_after_numbering_and_unique_ones_stay(names: list[str]) -> None:
    found = numbered(names)
    assert len(set(found)) == len(names)
    for name, new in zip(names, found, strict=True):
        assert new == name or (names.count(name) > 1 and new.startswith(f"{name}."))
