"""The bank is written clip by clip."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from motionsplice.motion.errors import BankError
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.baseline import Baseline, find_baseline
from motionsplice.precompute.job import bank_builder
from motionsplice.precompute.job.bank_builder import write_bank
from motionsplice.precompute.preparation.prepared import PreparedClip, prepare
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST
from tests.conftest import CLIPS


class Counting(Mapping[str, PreparedClip]):
    """Makes a new object whenever a clip is asked for, and counts those that are in use."""

    def __init__(self, clips: Mapping[str, PreparedClip]) -> None:
        self._clips, self._alive, self.most = clips, weakref.WeakSet[PreparedClip](), 0

    def __getitem__(self, name: str) -> PreparedClip:
        one = replace(self._clips[name])
        self._alive.add(one)
        self.most = max(self.most, len(self._alive))
        return one

    def __iter__(self) -> Iterator[str]:
        return iter(self._clips)

    def __len__(self) -> int:
        return len(self._clips)


@pytest.fixture(scope="module")
def walking() -> tuple[Rig, Baseline, PreparedClip]:
    walk, roles = CLIPS["walk"], find_roles(CLIPS["walk"].skeleton)
    rig, ring = Rig(walk.skeleton, roles), find_baseline(walk, roles)
    return rig, ring, replace(prepare(walk, roles, rig, ring), neutral="walk")


def test_a_manifest_that_no_reader_would_accept_is_not_written(
    walking: tuple[Rig, Baseline, PreparedClip], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, ring, walk = walking
    digest = write_bank(tmp_path, rig, ring, {"walk": walk})
    monkeypatch.setattr(bank_builder, "LARGEST_MANIFEST", (tmp_path / MANIFEST).stat().st_size)
    write_bank(tmp_path, rig, ring, {"walk": walk})
    with pytest.raises(BankError, match=r"readers take at most .* Split the clips into several banks"):
        write_bank(tmp_path, rig, ring, {"walk": walk, "other": replace(walk, name="other")})
    assert Bank.open(tmp_path).digest == digest


def test_no_more_than_a_clip_and_its_neutral_are_in_memory(tmp_path: Path) -> None:
    walk, roles = CLIPS["walk"], find_roles(CLIPS["walk"].skeleton)
    rig, ring = Rig(walk.skeleton, roles), find_baseline(walk, roles)
    prepared = prepare(walk, roles, rig, ring)
    clips = {
        f"wave{number}": replace(prepared, name=f"wave{number}", kind="action", neutral="walk") for number in range(9)
    }
    counting = Counting(clips | {"walk": replace(prepared, neutral="walk")})
    gc.disable()  # references alone must do
    try:
        digest = write_bank(tmp_path, rig, ring, counting)
    finally:
        gc.enable()
    assert counting.most <= 3
    assert Bank.open(tmp_path).digest == digest
