"""The example of a client runs unchanged."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

from tests.service.running import Running

EXAMPLE = Path(__file__).parents[2] / "examples" / "04_service.py"


def test_the_example_of_a_service_runs(
    service: Running, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE), f"http://127.0.0.1:{service.port}"])
    runpy.run_path(str(EXAMPLE))
    assert "22 joints" in capsys.readouterr().out
