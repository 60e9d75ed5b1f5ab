from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion.errors import MotionError
from motionsplice.precompute.job.cache import Arrays, Cache, Said, key_of

KEY, OTHER = key_of("one"), key_of("other")


def as_stored(said: Said, arrays: Arrays) -> tuple[Said, Arrays]:
    return said, dict(arrays)


@pytest.fixture
def cache(tmp_path: Path) -> Cache:
    cache = Cache(tmp_path / "cache")
    cache.store(KEY, {"rate": 0.1, "notes": ["a", "ä"]}, {"phase": np.linspace(0.0, 1.0, 7)})
    return cache


def test_an_entry_comes_back_to_the_last_bit(cache: Cache) -> None:
    found = cache.load(KEY, as_stored)
    assert found is not None
    assert found[0] == {"rate": 0.1, "notes": ["a", "ä"]}
    np.testing.assert_array_equal(found[1]["phase"], np.linspace(0.0, 1.0, 7))
    assert cache.holds(KEY)
    assert not cache.holds(OTHER)
    assert cache.load(OTHER, as_stored) is None


@pytest.mark.parametrize("at", [0, 40, 300, -30])
def test_a_damaged_entry_is_none(cache: Cache, at: int) -> None:
    file = cache.folder / f"{KEY}.npz"
    data = bytearray(file.read_bytes())
    data[at] ^= 0xFF
    file.write_bytes(data)
    found = cache.load(KEY, as_stored)
    assert found is None or found[0] == {"rate": 0.1, "notes": ["a", "ä"]}  # some bytes of a ZIP file mean nothing


def test_what_is_cut_short_or_something_else_is_none(cache: Cache) -> None:
    file = cache.folder / f"{KEY}.npz"
    data = file.read_bytes()
    pickled = np.array([{"a": 1}], dtype=object)
    for content in (b"", data[: len(data) // 2], b"PK\x03\x04", os.urandom(500)):
        file.write_bytes(content)
        assert cache.load(KEY, as_stored) is None
    np.savez(file, said=pickled)
    assert cache.load(KEY, as_stored) is None
    np.savez(file, phase=np.zeros(3))
    assert cache.load(KEY, as_stored) is None


def test_an_entry_that_does_not_fit_is_none(cache: Cache) -> None:
    assert cache.load(KEY, lambda said, arrays: arrays["rotations"]) is None


def test_only_what_is_used_stays_and_only_what_is_ours_goes(cache: Cache) -> None:
    cache.store(OTHER, {}, {})
    killed, running, mine = (cache.folder / name for name in (f".{KEY}.npz.12", f".{KEY}.npz.34", "mine.npz"))
    for file in (killed, running, mine):
        file.write_bytes(b"half")
    os.utime(killed, (0, 0))
    cache.keep_only([KEY])
    assert sorted(file.name for file in cache.folder.iterdir()) == sorted([f"{KEY}.npz", running.name, mine.name])


def test_a_disk_that_does_not_take_it_is_told(tmp_path: Path) -> None:
    (tmp_path / "cache").write_bytes(b"a file where the folder should be")
    with pytest.raises(MotionError, match="cache: results cannot be kept: File exists"):
        Cache(tmp_path / "cache").store(KEY, {}, {})
