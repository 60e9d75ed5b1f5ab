"""The short form of `python -m tests.hardening.damaged_banks`, in a process of its own, which may crash."""

from __future__ import annotations

import signal
import subprocess
import sys

import numpy as np
import pytest

from tests.hardening.damaged_banks import damage
from tests.hardening.guarded import guarded

READS = """
import ctypes, sys
import numpy as np
from tests.hardening.guarded import guarded
table = guarded(np.arange(int(sys.argv[1]), dtype=np.float32))
ctypes.string_at(table.ctypes.data + int(sys.argv[2]), 1)
"""


def test_damaged_banks_are_used_without_reading_outside_their_tables() -> None:
    command = [sys.executable, "-m", "tests.hardening.damaged_banks", "--flips", "40"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "40 damages" in done.stdout


@pytest.mark.parametrize(
    ("place", "ends"), [(0, 0), (4 * 48 - 1, 0), (4 * 48, -signal.SIGSEGV), (-4096, -signal.SIGSEGV)]
)
def test_reading_outside_a_guarded_array_ends_the_process(place: int, ends: int) -> None:
    given = [sys.executable, "-c", READS, "48", str(place)]
    assert subprocess.run(given, capture_output=True, check=False, timeout=60).returncode == ends


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
