from __future__ import annotations

import os
import signal
from pathlib import Path
from random import Random
from types import SimpleNamespace

import pytest

from bench.hostile import reading
from bench.hostile.good_files import DAMAGES, Good, good_files
from bench.hostile.reading import damaged, read, read_damaged
from motionsplice.motion.procedural.library import make
from tests.fbx_files import dump_fbx


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With an FBX file."""
    path = tmp_path_factory.mktemp("good")
    (path / "walk.fbx").write_bytes(dump_fbx([make("walk", seconds=0.1)]))
    return path


@pytest.fixture(params=DAMAGES)
def kind(request: pytest.FixtureRequest) -> str:
    if request.param == "fbx":
        pytest.importorskip("ufbx")
    return str(request.param)


def test_good_files_are_read_and_damaged_ones_differ(kind: str, folder: Path, tmp_path: Path) -> None:
    goods = good_files(kind, folder)
    assert goods
    for good in goods:
        for name, data in good.files.items():
            (tmp_path / name).write_bytes(data)
        assert read(tmp_path / good.name) == ("read", False)
    drawn = [damaged(kind, goods, 0, number) for number in range(40)]
    assert drawn == [damaged(kind, goods, 0, number) for number in range(40)]
    assert sum(one not in goods for one in drawn) > 35


def test_damaged_files_are_read_or_refused(kind: str, folder: Path) -> None:
    tally = read_damaged(kind, good_files(kind, folder), seed=3, count=200, jobs=2)
    assert tally.outcomes.total() == 200
    assert not tally.bad
    assert tally.outcomes["read"]


def test_an_exception_too_much_memory_time_and_a_crash_are_findings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each by its own file."""

    def hostile(kind: str, goods: list[Good], draw: Random) -> Good:
        return Good({"one.bvh": draw.choice([b"exception", b"memory", b"time", b"crash", b"fine"])})

    clip = make("walk", seconds=0.5)

    def read_clip(path: Path, animation: None) -> SimpleNamespace:
        match path.read_bytes():
            case b"exception":
                raise KeyError("joint")
            case b"memory":
                bytearray(300 * 2**20)
            case b"time":
                sum(range(10**6))
            case b"crash":
                os.kill(os.getpid(), signal.SIGKILL)
        return SimpleNamespace(clip=clip)

    monkeypatch.setattr(reading, "hostile", hostile)
    monkeypatch.setattr(reading, "read_clip", read_clip)
    monkeypatch.setattr(reading, "MOST_SECONDS", 0.005)
    tally = read_damaged("bvh", [], seed=0, count=30, jobs=2)
    assert tally.outcomes.total() == 30
    assert len(tally.bad) == 4
    assert "the process ended with -9" in tally.bad
    assert any(outcome.startswith("slow: read") for outcome in tally.bad)
    for kind in ("KeyError in test_hostile.py", "MemoryError in test_hostile.py"):
        assert any(outcome.startswith(kind) for outcome in tally.bad)
