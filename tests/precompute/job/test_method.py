from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

import pytest

from motionsplice.precompute.job import method
from motionsplice.precompute.job.method import PACKAGES, _sources, version_of_method


@pytest.fixture
def forgotten() -> Iterator[None]:
    """Lets the next test compute the version anew, whatever this one leaves."""
    yield
    version_of_method.cache_clear()


@pytest.mark.usefixtures("forgotten")
def test_the_version_depends_on_every_source_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package in PACKAGES:
        (tmp_path / package / "inner").mkdir(parents=True)
    deep = tmp_path / PACKAGES[-1] / "inner" / "deep.py"
    deep.write_text("ONE = 1\n")
    monkeypatch.setattr(method, "files", lambda package: tmp_path / package.removeprefix("motionsplice."))

    def now() -> str:
        version_of_method.cache_clear()
        return version_of_method()

    before = now()
    (deep.parent / "__pycache__").mkdir()
    (deep.parent / "__pycache__" / "deep.py").write_text("")
    assert now() == before
    deep.write_text("ONE = 2\n")
    changed = now()
    monkeypatch.setattr(method, "version", lambda library: "0")
    assert len({before, changed, now()}) == 3


def test_the_sources_are_found() -> None:
    found = {package: dict(_sources(files(f"motionsplice.{package}"), package)) for package in PACKAGES}
    assert b"def version_of_method" in found["precompute"]["precompute/job/method.py"]
    assert "motion/formats/bvh/reader.py" in found["motion"]
    assert "runtime/kernels/posture.py" in found["runtime"]
