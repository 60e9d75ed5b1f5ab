"""Each example runs as it stands."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))
NEEDS_A_SERVICE = "04_service.py"


@pytest.mark.parametrize("example", [one for one in EXAMPLES if one.name != NEEDS_A_SERVICE], ids=lambda one: one.name)
def test_an_example_runs(
    example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(example))
    assert capsys.readouterr().out
    assert list((tmp_path / "example").iterdir())


def test_all_are_listed() -> None:
    page = (EXAMPLES[0].parent / "README.md").read_text(encoding="utf-8")
    assert [one.name for one in EXAMPLES if f"]({one.name})" not in page] == []
