from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from bench.speed.first_call import PROJECT, STEPS, child, median, sealed_copy
from motionsplice.runtime.bank import Bank
from tests.sealed import run_without_rights, sealed

COUNTING = """
import gc, sys
from numba.core.dispatcher import Dispatcher
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
bank = Bank.open(sys.argv[1])
Evaluator(bank).pose(Splice(bank.clips[0].name, bank.clips[-1].name), 0.5)
kernels = [one.stats for one in gc.get_objects() if isinstance(one, Dispatcher) and one.stats.cache_path]
print(sum(bool(one.cache_hits) for one in kernels), *(one for one in kernels if one.cache_misses))
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return sealed_copy(tmp_path_factory.mktemp("package"))


@pytest.fixture(scope="module")
def kernels(bank: Bank, package: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the kernels of a frame; those of characters are cached likewise."""
    kernels = tmp_path_factory.mktemp("kernels")
    child(package, bank.path, {"NUMBA_CACHE_DIR": str(kernels)}, characters=False)
    return kernels


def test_a_process_is_measured_in_steps(bank: Bank) -> None:
    assert len(child(PROJECT, bank.path, {})) == len(STEPS)


def test_a_read_only_package_caches_its_kernels_in_numba_cache_dir(bank: Bank, package: Path, kernels: Path) -> None:
    written = {file: file.stat().st_mtime_ns for file in kernels.rglob("*.nb?")}
    child(package, bank.path, {"NUMBA_CACHE_DIR": str(kernels)}, characters=False)
    assert {file: file.stat().st_mtime_ns for file in kernels.rglob("*.nb?")} == written  # nothing is compiled again
    names = {file.name for file in kernels.rglob("*.nbc")}
    assert any(name.startswith("evaluate.evaluate") for name in names)
    assert not list(package.rglob("*.nb?"))


@pytest.mark.skipif(os.name != "posix", reason="folders have no modes")
def test_a_read_only_package_takes_all_kernels_from_a_read_only_cache(bank: Bank, package: Path, kernels: Path) -> None:
    command = [sys.executable, "-c", COUNTING, str(bank.path)]
    with sealed(kernels):
        found = run_without_rights(command, {"NUMBA_CACHE_DIR": str(kernels), "PYTHONPATH": str(package)})
    assert found.strip().isdigit()  # none was compiled
    assert int(found) > 0


def test_the_median_is_taken_step_by_step() -> None:
    assert median([[1.0, 9.0], [2.0, 7.0], [3.0, 8.0]]) == [2.0, 8.0]
