from __future__ import annotations

from pathlib import Path

import pytest

from bench.speed import reading
from motionsplice.motion.formats.files import write_clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles


def test_files_are_read_in_turns_and_told_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(reading, "LONG", {"long.bvh": 2.0, "long.glb": 2.0})
    clip = make("walk", "wave", seconds=2.0)
    write_clip(tmp_path / "mine.glb", clip, find_roles(clip.skeleton))
    taken = iter(range(1, 10))
    monkeypatch.setattr(reading, "reading", lambda path, animation: 1000.0 * next(taken))
    reading.main([tmp_path / "mine.glb"], times=2)
    printed = capsys.readouterr().out
    for label, median, slowest in (("long.bvh", 5500, 7000), ("long.glb", 6500, 8000), ("mine.glb", 7500, 9000)):
        rows = [line.split("│")[1:3] for line in printed.splitlines() if label in line and "│" in line]
        assert [float(value) for _, value in rows] == [median, slowest]
    assert "long.bvh, 0.1 MB: median of 2 is 5500, target" in printed
    assert "mine.glb, 0.0 MB: median of 2 is" not in printed
