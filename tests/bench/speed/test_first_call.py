from __future__ import annotations

from pathlib import Path

from bench.speed.first_call import PROJECT, STEPS, child, median, sealed_copy
from motionsplice.runtime.bank import Bank


def test_a_process_is_measured_in_steps(bank: Bank) -> None:
    assert len(child(PROJECT, bank.path, {})) == len(STEPS)


def test_a_read_only_package_caches_its_kernels_in_numba_cache_dir(bank: Bank, tmp_path: Path) -> None:
    sealed, cache = sealed_copy(tmp_path / "sealed"), tmp_path / "cache"
    environment = {"NUMBA_CACHE_DIR": str(cache)}
    child(sealed, bank.path, environment, characters=False)  # their kernels are cached likewise
    written = {file: file.stat().st_mtime_ns for file in cache.rglob("*.nb?")}
    child(sealed, bank.path, environment, characters=False)
    assert {file: file.stat().st_mtime_ns for file in cache.rglob("*.nb?")} == written  # nothing is compiled again
    kernels = {file.name for file in cache.rglob("*.nbc")}
    assert any(name.startswith("evaluate.evaluate") for name in kernels)
    assert not list(sealed.rglob("*.nb?"))


def test_the_median_is_taken_step_by_step() -> None:
    assert median([[1.0, 9.0], [2.0, 7.0], [3.0, 8.0]]) == [2.0, 8.0]
