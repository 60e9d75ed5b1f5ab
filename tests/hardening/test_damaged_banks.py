"""The short form of `python -m tests.hardening.damaged_banks`, in a process of its own, which may crash."""

from __future__ import annotations

import ctypes
import faulthandler
import signal
from collections.abc import Callable

import numpy as np
import pytest

from tests.hardening.damaged_banks import check, damage
from tests.hardening.guarded import guarded
from tests.hardening.killed import FORK

COUNT = 48  # numbers of 4 bytes: 192 bytes, which need no room after them


def status(target: Callable[..., object], *arguments: int) -> int | None:
    """Returns the exit status of a process that calls a function."""
    process = FORK.Process(target=target, args=arguments)
    process.start()
    process.join()
    return process.exitcode


def read(place: int) -> None:
    """Reads a byte, counted from the begin of a guarded array."""
    faulthandler.disable()
    table = guarded(np.arange(COUNT, dtype=np.float32))
    ctypes.string_at(table.ctypes.data + place, 1)


def test_damaged_banks_are_used_without_reading_outside_their_tables() -> None:
    assert status(check, 40, 0) == 0


@pytest.mark.parametrize(
    ("place", "ends"), [(0, 0), (4 * COUNT - 1, 0), (4 * COUNT, -signal.SIGSEGV), (-4096, -signal.SIGSEGV)]
)
def test_reading_outside_a_guarded_array_ends_the_process(place: int, ends: int) -> None:
    assert status(read, place) == ends


@pytest.mark.parametrize("count", [1, 16, 1024, 5000])
def test_a_guarded_array_is_a_copy_aligned_as_a_table(count: int) -> None:
    table = np.arange(3 * count, dtype=np.float64).reshape(count, 3)
    copy = guarded(table)
    np.testing.assert_array_equal(copy, table)
    assert copy.ctypes.data % 64 == 0


def test_damage_changes_one_number() -> None:
    draw, table = np.random.default_rng(0), np.ones(50, np.float32)
    for _ in range(100):
        damaged = table.copy()
        damage(damaged, draw)
        assert (damaged.view(np.int32) != table.view(np.int32)).sum() == 1
