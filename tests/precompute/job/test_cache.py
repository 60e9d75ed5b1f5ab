from __future__ import annotations

import os
import zlib
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from motionsplice.motion.errors import MotionError
from motionsplice.precompute.job.cache import MAGIC, START, Arrays, Cache, Fields, key_of

KEY, OTHER = key_of("one"), key_of("other")


def as_stored(fields: Fields, arrays: Arrays) -> tuple[Fields, Arrays]:
    return fields, dict(arrays)


@pytest.fixture
def cache(tmp_path: Path) -> Cache:
    cache = Cache(tmp_path / "cache")
    cache.store(KEY, {"rate": 0.1, "notes": ["a", "ä"]}, {"phase": np.linspace(0.0, 1.0, 7)})
    return cache


def test_an_entry_loads_exactly_as_stored(cache: Cache) -> None:
    found = cache.load(KEY, as_stored)
    assert found is not None
    assert found[0] == {"rate": 0.1, "notes": ["a", "ä"]}
    np.testing.assert_array_equal(found[1]["phase"], np.linspace(0.0, 1.0, 7))
    assert cache.holds(KEY)
    assert not cache.holds(OTHER)
    assert cache.load(OTHER, as_stored) is None


def test_an_entry_with_any_byte_changed_or_cut_off_loads_as_none(cache: Cache) -> None:
    file = cache.folder / f"{KEY}.entry"
    data = file.read_bytes()
    for at in range(len(data)):
        file.write_bytes(data[:at] + bytes([data[at] ^ 0xFF]) + data[at + 1 :])
        assert cache.load(KEY, as_stored) is None
        file.write_bytes(data[:at])
        assert cache.load(KEY, as_stored) is None


def test_a_foreign_file_loads_as_none(cache: Cache) -> None:
    file = cache.folder / f"{KEY}.entry"
    for content in (b"", b"PK\x03\x04", os.urandom(500)):
        file.write_bytes(content)
        assert cache.load(KEY, as_stored) is None


@pytest.mark.parametrize(
    "described",
    [
        (0, "<f8", [10**12], 0),  # more than the file holds
        (0, "<f8", [2**62, 2**62], 0),
        (0, "<f8", [-1, -7], 0),
        (-56, "<f8", [7], 0),
        (10**9, "<f8", [0], 0),
        (0, "|O", [7], 0),  # would be pointers
        (0, "<U99999999", [1], 0),
        (0, [["a", "<f8"]], [7], 0),
        (0, "<f8", ["7"], 0),
        (0, "<f8", 7, 0),
        "phase",
    ],
)
def test_an_entry_whose_head_claims_what_it_does_not_hold_loads_as_none(cache: Cache, described: Any) -> None:
    head = msgpack.packb(({}, {"phase": described}))
    numbers = np.linspace(0.0, 1.0, 7).tobytes()
    (cache.folder / f"{KEY}.entry").write_bytes(START.pack(MAGIC, len(head), zlib.crc32(head)) + head + numbers)
    assert cache.load(KEY, as_stored) is None


@pytest.mark.parametrize("shape", [(), (0,), (0, 3), (2, 3, 4)])
@pytest.mark.parametrize("kind", [np.uint8, np.int64, np.float32, np.float64])
def test_arrays_of_any_shape_keep_it(cache: Cache, shape: tuple[int, ...], kind: type) -> None:
    array = np.asfortranarray(np.arange(np.prod(shape, dtype=int), dtype=kind).reshape(shape or 1))
    cache.store(OTHER, {}, {"array": array})
    found = cache.load(OTHER, lambda _, arrays: arrays["array"])
    assert found is not None
    assert found.dtype == kind
    np.testing.assert_array_equal(found, array)


def test_an_entry_without_the_expected_array_loads_as_none(cache: Cache) -> None:
    assert cache.load(KEY, lambda fields, arrays: arrays["rotations"]) is None


def test_keep_only_removes_unused_entries_and_no_foreign_files(cache: Cache) -> None:
    cache.store(OTHER, {}, {})
    killed, mine = cache.folder / f".{KEY}.entry.12", cache.folder / "mine.entry"
    for file in (killed, mine):
        file.write_bytes(b"half")
    cache.keep_only([KEY])
    assert sorted(file.name for file in cache.folder.iterdir()) == sorted([f"{KEY}.entry", mine.name])


def test_an_entry_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "cache").write_bytes(b"a file where the folder should be")
    with pytest.raises(
        MotionError, match=r"cache: cannot write to the cache: File exists\. A file .* is in the folder's"
    ):
        Cache(tmp_path / "cache").store(KEY, {}, {})
