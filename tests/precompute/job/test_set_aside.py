from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from motionsplice.motion.formats.reading import Reading
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.job.set_aside import SetAside
from tests.conftest import CLIPS


def reading_of(name: str) -> Reading:
    clip = CLIPS[name]
    return Reading(clip, find_roles(clip.skeleton), 0.01, ("a note",), ("a warning",))


@pytest.fixture
def aside(tmp_path: Path) -> Iterator[SetAside]:
    aside = SetAside(tmp_path / "cache")
    yield aside
    aside.close()


def test_readings_come_back_as_they_were_in_any_order(aside: SetAside) -> None:
    readings = {name: reading_of(name) for name in ("walk", "run")}
    part = readings["walk"].clip.frames(3, 20)  # shares memory with others
    readings["part"] = replace(readings["walk"], clip=replace(part, rotations=part.rotations[::-1]))
    for name, reading in readings.items():
        aside.put(name, reading)
    for name in ("part", "walk", "run", "walk"):
        found, wanted = aside.get(name), readings[name]
        assert found is not None
        np.testing.assert_array_equal(found.clip.rotations, wanted.clip.rotations)
        np.testing.assert_array_equal(found.clip.root_positions, wanted.clip.root_positions)
        assert (found.clip.skeleton, found.clip.rate) == (wanted.clip.skeleton, wanted.clip.rate)
        assert (found.roles, found.unit, found.notes, found.warnings) == (
            wanted.roles,
            0.01,
            ("a note",),
            ("a warning",),
        )
    assert aside.get("jump") is None


def test_threads_do_not_mix_their_readings(aside: SetAside) -> None:
    readings = [reading_of(name) for name in ("walk", "run", "side_step") for _ in range(20)]

    def there_and_back(number: int) -> bool:
        aside.put(str(number), readings[number])
        found = aside.get(str(number))
        return found is not None and np.array_equal(found.clip.rotations, readings[number].clip.rotations)

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(there_and_back, range(len(readings))))


def test_the_file_has_no_name(aside: SetAside, tmp_path: Path) -> None:
    aside.put("walk", reading_of("walk"))
    assert list((tmp_path / "cache").iterdir()) == []


def test_a_reading_that_cannot_be_written_or_read_back_is_missing(tmp_path: Path) -> None:
    (tmp_path / "cache").write_bytes(b"a file where the folder should be")
    nowhere = SetAside(tmp_path / "cache")
    nowhere.put("walk", reading_of("walk"))
    assert nowhere.get("walk") is None
    nowhere.close()
    aside = SetAside(tmp_path)
    aside.put("walk", reading_of("walk"))
    aside._file.truncate(1000)
    assert aside.get("walk") is None
    with patch.object(SetAside, "_file") as broken:
        broken.seek.side_effect = OSError
        assert aside.get("walk") is None
    aside.close()
