"""Kernels are cached where Numba may write, and read where it may not."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.sealed import run_without_rights, sealed

MODULE = """
from motionsplice.motion.kernel_cache import compiled

@compiled(nogil=True)
def doubled(number):
    return 2 * number
"""
CHILD = """
import json, sys
sys.path[:0] = sys.argv[1:3]
from kernels import doubled
number = json.loads(sys.argv[3])
assert doubled(number) == 2 * number
print(json.dumps([sum(doubled.stats.cache_hits.values()), sum(doubled.stats.cache_misses.values())]))
"""
PROJECT = Path(__file__).parents[2]
HIT, MISS = [1, 0], [0, 1]

pytestmark = pytest.mark.skipif(os.name != "posix", reason="folders have no modes")


@pytest.fixture
def package(tmp_path: Path) -> Path:
    package = tmp_path / "package"
    package.mkdir()
    (package / "kernels.py").write_text(MODULE)
    return package


def command(package: Path, number: float) -> list[str]:
    return [sys.executable, "-c", CHILD, str(PROJECT), str(package), json.dumps(number)]


def fill(package: Path, environment: dict[str, str]) -> None:
    """Compiles the kernel for integers into the cache."""
    done = subprocess.run(
        command(package, 1), env={**os.environ, **environment}, check=True, capture_output=True, text=True
    )
    assert json.loads(done.stdout) == MISS


def evaluated(package: Path, number: float, environment: dict[str, str]) -> list[int]:
    """Returns how many kernels a process found in the cache, and how many it compiled."""
    found: list[int] = json.loads(run_without_rights(command(package, number), environment))
    return found


def files(folder: Path) -> set[Path]:
    return {file for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize("chosen", ["", "kernels"], ids=["beside the source", "NUMBA_CACHE_DIR"])
def test_a_filled_cache_that_may_not_be_written_is_read(package: Path, chosen: str) -> None:
    environment = {"NUMBA_CACHE_DIR": chosen and str(package / chosen)}
    fill(package, environment)
    before = files(package)
    with sealed(package):
        assert evaluated(package, 1, environment) == HIT
        assert evaluated(package, 1.5, environment) == MISS  # another type, which cannot be saved
        assert evaluated(package, 1.5, environment) == MISS
    assert files(package) == before


def test_without_a_cache_kernels_are_compiled_for_the_process(package: Path) -> None:
    with sealed(package):
        assert evaluated(package, 1, {"NUMBA_CACHE_DIR": str(package / "kernels")}) == MISS


def test_what_a_read_only_cache_does_not_have_goes_into_the_users_own(package: Path, tmp_path: Path) -> None:
    fill(package, {"NUMBA_CACHE_DIR": ""})
    home = {"XDG_CACHE_HOME": str(tmp_path / "home")}
    with sealed(package):
        assert evaluated(package, 1, home) == HIT
        assert evaluated(package, 1.5, home) == MISS
        assert evaluated(package, 1.5, home) == HIT


def test_a_cache_that_may_not_be_entered_is_no_error(package: Path) -> None:
    fill(package, {"NUMBA_CACHE_DIR": ""})
    with sealed(package):
        (package / "__pycache__").chmod(0o000)
        assert evaluated(package, 1, {}) == MISS


def test_a_read_only_cache_of_another_source_is_not_used(package: Path) -> None:
    fill(package, {"NUMBA_CACHE_DIR": ""})
    (package / "kernels.py").write_text(MODULE.replace("2 * number", "number + number"))
    with sealed(package):
        assert evaluated(package, 1, {}) == MISS
