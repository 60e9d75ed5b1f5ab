from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion.errors import MotionError
from motionsplice.precompute.job.cache import Arrays, Cache, Fields, key_of

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


@pytest.mark.parametrize("at", [0, 40, 300, -30])
def test_a_damaged_entry_loads_as_none(cache: Cache, at: int) -> None:
    file = cache.folder / f"{KEY}.npz"
    data = bytearray(file.read_bytes())
    data[at] ^= 0xFF
    file.write_bytes(data)
    found = cache.load(KEY, as_stored)
    assert found is None or found[0] == {"rate": 0.1, "notes": ["a", "ä"]}  # some bytes of a ZIP file are not used


def test_a_truncated_or_foreign_file_loads_as_none(cache: Cache) -> None:
    file = cache.folder / f"{KEY}.npz"
    data = file.read_bytes()
    pickled = np.array([{"a": 1}], dtype=object)
    for content in (b"", data[: len(data) // 2], b"PK\x03\x04", os.urandom(500)):
        file.write_bytes(content)
        assert cache.load(KEY, as_stored) is None
    np.savez(file, fields=pickled)
    assert cache.load(KEY, as_stored) is None
    np.savez(file, phase=np.zeros(3))
    assert cache.load(KEY, as_stored) is None


def test_an_entry_without_the_expected_array_loads_as_none(cache: Cache) -> None:
    assert cache.load(KEY, lambda fields, arrays: arrays["rotations"]) is None


def test_keep_only_removes_unused_entries_and_no_foreign_files(cache: Cache) -> None:
    cache.store(OTHER, {}, {})
    killed, running, mine = (cache.folder / name for name in (f".{KEY}.npz.12", f".{KEY}.npz.34", "mine.npz"))
    for file in (killed, running, mine):
        file.write_bytes(b"half")
    os.utime(killed, (0, 0))
    cache.keep_only([KEY])
    assert sorted(file.name for file in cache.folder.iterdir()) == sorted([f"{KEY}.npz", running.name, mine.name])


def test_an_entry_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "cache").write_bytes(b"a file where the folder should be")
    with pytest.raises(MotionError, match="cache: cannot write to the cache: File exists"):
        Cache(tmp_path / "cache").store(KEY, {}, {})
