from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion.clip_settings import ClipSettings
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.precompute.job import clip_work
from motionsplice.precompute.job.cache import Cache
from motionsplice.precompute.job.clip_work import Identified, Readings, contents_of, identify, read
from motionsplice.precompute.job.sources import Source
from tests.conftest import CLIPS


@pytest.fixture
def walk(tmp_path: Path) -> Identified:
    file = tmp_path / "walk.bvh"
    file.write_bytes(dump_bvh(CLIPS["walk"]))
    return identify(Source("walk", file, None, ClipSettings(unit="m")), contents_of(file))


@pytest.mark.parametrize("handed", [True, False])
def test_a_kept_clip_is_not_read_again_and_has_the_name_it_is_asked_for(
    walk: Identified, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, handed: bool
) -> None:
    readings, reading = Readings(Cache(tmp_path / "cache")), read(walk)
    kept = readings if handed else pickle.loads(pickle.dumps(readings))  # as in a worker process
    kept.keep(walk, reading)
    assert kept.cache.holds(walk.reading_key) is not handed
    monkeypatch.setattr(clip_work, "read", lambda one: pytest.fail("it was read again"))
    same = (kept if handed else readings).of(replace(walk, source=replace(walk.source, name="copy")))
    assert same.clip.name == "copy"
    np.testing.assert_array_equal(same.clip.rotations, reading.clip.rotations)
    np.testing.assert_array_equal(same.clip.root_positions, reading.clip.root_positions)
    assert (same.unit, same.notes, same.roles) == (reading.unit, reading.notes, reading.roles)


def test_a_clip_that_was_not_kept_is_read(walk: Identified, tmp_path: Path) -> None:
    np.testing.assert_array_equal(
        Readings(Cache(tmp_path / "cache")).of(walk).clip.rotations, read(walk).clip.rotations
    )
