from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion.clip_settings import ClipSettings
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.precompute.job import readings as reading_module
from motionsplice.precompute.job.cache import Cache
from motionsplice.precompute.job.clip_work import Preparation, StrideSearch
from motionsplice.precompute.job.entries import FoundStride, pack_prepared
from motionsplice.precompute.job.readings import ROOM, Identified, Readings, contents_of, identify, read
from motionsplice.precompute.job.sources import Source
from tests.conftest import CLIPS


@pytest.fixture
def walk(tmp_path: Path) -> Identified:
    file = tmp_path / "walk.bvh"
    file.write_bytes(dump_bvh(CLIPS["walk"]))
    return identify(Source("walk", file, None, ClipSettings(unit="m")), contents_of(file))


@pytest.mark.parametrize("where", ["memory", "file", "worker"])
def test_a_kept_clip_is_not_read_again_and_has_the_name_it_is_asked_for(
    walk: Identified, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    readings, reading = Readings(Cache(tmp_path / "cache"), room=1 if where == "file" else ROOM), read(walk)
    kept = pickle.loads(pickle.dumps(readings)) if where == "worker" else readings
    kept.keep(walk, reading)
    assert kept.cache.holds(walk.reading_key) is (where == "worker")
    monkeypatch.setattr(reading_module, "read", lambda one: pytest.fail("it was read again"))
    same = readings.of(replace(walk, source=replace(walk.source, name="copy")))
    assert same.clip.name == "copy"
    np.testing.assert_array_equal(same.clip.rotations, reading.clip.rotations)
    np.testing.assert_array_equal(same.clip.root_positions, reading.clip.root_positions)
    assert (same.unit, same.notes, same.roles) == (reading.unit, reading.notes, reading.roles)
    readings.close()


def test_a_clip_that_was_not_kept_is_read(walk: Identified, tmp_path: Path) -> None:
    np.testing.assert_array_equal(
        Readings(Cache(tmp_path / "cache")).of(walk).clip.rotations, read(walk).clip.rotations
    )


def test_results_are_remembered_as_far_as_there_is_room_and_not_in_workers(tmp_path: Path) -> None:
    readings = Readings(Cache(tmp_path / "cache"), room=100)
    for key, size in (("large", 101), ("small", 60), ("one more", 60)):
        readings.remember(key, f"what is {key}", size)
    assert [readings.result(key) for key in ("large", "small", "one more")] == [None, "what is small", None]
    copy = pickle.loads(pickle.dumps(readings))
    copy.remember("tiny", "what is tiny", 1)
    assert (copy.result("small"), copy.result("tiny")) == (None, None)


def test_a_remembered_result_equals_the_one_in_the_cache(walk: Identified, tmp_path: Path) -> None:
    searches = [StrideSearch(Readings(Cache(tmp_path / "cache"), room)) for room in (0, ROOM)]
    copy = replace(walk, source=replace(walk.source, name="copy"))
    searches[1].run(walk)
    stored, remembered = (one.load(copy) for one in searches)
    assert stored is not None
    assert remembered is not None
    assert stored.ring is not None
    assert remembered.ring is not None
    assert stored.ring.name == remembered.ring.name == "copy"
    assert stored.rig.skeleton == remembered.rig.skeleton
    preparations = [Preparation.of(one.readings, FoundStride(stored.rig, stored.ring), True) for one in searches]
    preparations[1].run(walk)
    one, other = (preparation.load(copy) for preparation in preparations)
    assert one is not None
    assert other is not None
    for found, wanted in zip(pack_prepared(other)[1].items(), pack_prepared(one)[1].items(), strict=True):
        assert found[0] == wanted[0]
        np.testing.assert_array_equal(found[1], wanted[1])
    fields = [{**pack_prepared(found)[0], "notes": list(found.notes)} for found in (one, other)]
    assert fields[0] == fields[1]
    assert (one.name, one.source, one.kind) == (other.name, other.source, other.kind) == ("copy", one.source, one.kind)
