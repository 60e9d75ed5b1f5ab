from __future__ import annotations

from pathlib import Path

import pytest

from motionsplice.precompute.job import method
from motionsplice.precompute.job.method import version_of


def test_the_version_depends_on_every_source_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "ours" / "inner").mkdir(parents=True)
    (tmp_path / "ours" / "__init__.py").write_text("")
    (tmp_path / "ours" / "inner" / "deep.py").write_text("ONE = 1\n")
    monkeypatch.setattr(method, "files", lambda package: tmp_path / package.removeprefix("motionsplice."))

    def now() -> str:
        version_of.cache_clear()
        return version_of("ours")

    before = now()
    (tmp_path / "ours" / "__pycache__").mkdir()
    (tmp_path / "ours" / "__pycache__" / "deep.py").write_text("")
    assert now() == before
    (tmp_path / "ours" / "inner" / "deep.py").write_text("ONE = 2\n")
    changed = now()
    monkeypatch.setattr(method, "version", lambda library: "0")
    assert len({before, changed, now()}) == 3
    version_of.cache_clear()


def test_the_sources_are_found() -> None:
    assert len({version_of("motion"), version_of("precompute"), version_of("motion", "precompute")}) == 3
