"""The short form of `python -m tests.hardening.fuzz`: some hundred inputs of each door, always the same ones."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random

import numpy as np
import pytest

from motionsplice.motion.errors import MotionError, SettingsError
from tests.hardening.fuzz import harness
from tests.hardening.fuzz.door import DOORS, Door, Files, door_of
from tests.hardening.fuzz.draw import Draw
from tests.hardening.fuzz.harness import Tally, Visitor
from tests.hardening.fuzz.held import held

INPUTS = 60
LONGEST = 4096  # bytes of choices


@contextmanager
def visiting(door: Door, saved: Path | None = None) -> Iterator[Visitor]:
    visitor = Visitor(door, saved)
    yield visitor
    visitor.close()


@pytest.mark.parametrize("name", DOORS)
def test_whatever_comes_to_a_door_passes_or_is_refused_by_a_typed_error(name: str) -> None:
    with visiting(door_of(name)) as visitor:
        for number in range(INPUTS):
            visitor.visit(Random(f"{name} {number}").randbytes(LONGEST))
    tally = visitor.tally
    assert not tally.bad
    assert tally.inputs + tally.repeated == INPUTS
    assert tally.passed_first > tally.inputs / 3
    assert 0 < tally.passed < tally.inputs


@pytest.mark.parametrize("name", DOORS)
def test_without_oddities_an_input_is_sound(name: str, tmp_path: Path) -> None:
    door = door_of(name)
    door.enter(door.make(Draw(b"")), tmp_path)


def door(enter: Callable[[Files, Path], None]) -> Door:
    return Door(lambda draw: {"x": bytes(draw.randrange(100))}, enter, re.compile("$^"))


def large(files: Files, folder: Path) -> None:
    bytearray(4 * harness.FREE)


def untyped(files: Files, folder: Path) -> None:
    raise KeyError("x")


def wordless(files: Files, folder: Path) -> None:
    raise MotionError("")


def warning(files: Files, folder: Path) -> None:
    np.float32(1e30) * np.float32(1e30)


def refused(files: Files, folder: Path) -> None:
    raise SettingsError("no 'walk' in 12 files")


@pytest.mark.parametrize(
    ("enter", "words"),
    [
        (large, "MemoryError"),
        (untyped, "KeyError"),
        (wordless, "a problem without words"),
        (warning, "RuntimeWarning"),
    ],
)
def test_anything_but_a_typed_error_is_found(enter: Callable[[Files, Path], None], words: str, tmp_path: Path) -> None:
    with visiting(door(enter), tmp_path) as visitor:
        visitor.visit(b"x\x07")
    ((found, saved),) = visitor.tally.bad.items()
    assert found.startswith(words)
    assert (Path(saved) / "x").read_bytes() == bytes(Draw(b"x\x07").randrange(100))


def test_slow_inputs_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(harness, "MOST_SECONDS", -1.0)
    with visiting(door(refused)) as visitor:
        visitor.visit(b"")
    assert list(visitor.tally.bad) == ["slow: no 'walk' in 12 files"]


def test_outcomes_are_counted_without_their_names_and_numbers(tmp_path: Path) -> None:
    with visiting(door(refused)) as visitor:
        visitor.visit(b"")
    tally = visitor.tally
    assert (tally.inputs, tally.passed_first, tally.passed, tally.bad) == (1, 1, 0, {})
    assert tally.outcomes == {"no … in … files": 1}
    tally.write(tmp_path / "tally.json")
    assert Tally.read(tmp_path / "tally.json") == tally


def test_an_input_that_was_sent_before_is_not_sent_again() -> None:
    with visiting(door(refused)) as visitor:
        assert [visitor.visit(data) for data in (b"x\x07", b"x\x08", b"y\x07")] == [True, True, False]
    assert (visitor.tally.inputs, visitor.tally.repeated) == (2, 1)


def test_a_tally_counts_on_from_that_of_an_earlier_run(tmp_path: Path) -> None:
    tally = Tally.read(tmp_path / "none.json")
    for _ in range(2):
        visitor = Visitor(door(refused), tally=tally)
        visitor.visit(b"")
        visitor.close()
    assert (tally.inputs, tally.outcomes) == (2, {"no … in … files": 2})


def test_a_change_of_one_byte_changes_no_later_choice() -> None:
    data = bytes(range(7, 207))
    for at in range(1, 6):
        draws = [Draw(data), Draw(data[:at] + b"\xff" + data[at + 1 :])]
        for draw in draws:
            draw.sample(range(10), 5)
        assert draws[0].randrange(1000) == draws[1].randrange(1000)


def test_files_in_memory_read_as_files_on_the_disk_do(tmp_path: Path) -> None:
    data = "\ufeffa\r\nb\rc".encode()
    (tmp_path / "disk").write_bytes(data)
    (file,) = held({"memory": data}, tmp_path).values()
    assert file.read_bytes() == data
    assert file.read_text(encoding="utf-8") == (tmp_path / "disk").read_text(encoding="utf-8")
    with pytest.raises(UnicodeDecodeError):
        held({"memory": b"\xff"}, tmp_path)["memory"].read_text(encoding="utf-8")
