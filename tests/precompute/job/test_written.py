from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from motionsplice.precompute.job.written import write_synced, write_tables
from motionsplice.runtime.format.manifest import content_digest

PHASES = np.linspace(0.0, 1.0, 7)


def test_a_table_is_its_parts_end_to_end_under_the_digest_of_its_file(tmp_path: Path) -> None:
    digests = write_tables(tmp_path, {"phase_of_frame": (7, [PHASES[:3], PHASES[3:]]), "neutral": (1, [np.array([2])])})
    assert list(digests) == ["phase_of_frame", "neutral"]
    assert {file.stem for file in tmp_path.iterdir()} == set(digests.values())
    file = tmp_path / f"{digests['phase_of_frame']}.npy"
    assert content_digest(file.read_bytes()) == file.stem
    np.testing.assert_array_equal(np.load(file), PHASES)


def test_equal_tables_share_a_file(tmp_path: Path) -> None:
    digests = write_tables(tmp_path, {"hand_frames": (3, [np.zeros((3, 2))]), "paths": (3, [np.zeros((3, 2))])})
    assert digests["hand_frames"] == digests["paths"]
    assert len(list(tmp_path.iterdir())) == 1


def test_contents_are_on_the_disk_before_names_and_names_before_it_returns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []
    sync, rename = os.fsync, Path.replace

    def synced(descriptor: int) -> None:
        sync(descriptor)
        done.append("folder" if os.path.samestat(os.fstat(descriptor), tmp_path.stat()) else "content")

    def renamed(self: Path, target: Path) -> Path:
        done.append("name")
        return rename(self, target)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(Path, "replace", renamed)
    write_tables(tmp_path, {"phase_of_frame": (7, [PHASES]), "neutral": (1, [np.array([2])])})
    write_synced(tmp_path / "manifest", b"current")
    assert done == ["content", "content", "name", "name", "folder", "content", "folder", "name", "folder"]
