"""What docs/protocol.md says, tried out."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from service.problems import PROBLEMS
from tests.service.running import Running

PAGE = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text()


def test_its_clients_work(service: Running, capsys: pytest.CaptureFixture[str]) -> None:
    examples = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(examples) == 2
    for example in examples:
        exec(example.replace("127.0.0.1:8000", f"127.0.0.1:{service.port}").replace("curve", "run"), {})
    told = capsys.readouterr().out
    assert "22 joints" in told
    assert "frame 60 of 2 characters" in told


def test_it_names_every_problem() -> None:
    for status, kind in set(PROBLEMS.values()):
        assert re.search(rf"\|[ \d,]*{status}[ \d,]*\|[^|]*`{kind}`", PAGE), (status, kind)


def test_it_names_every_operation(service: Running) -> None:
    for path in service.config.front.app.openapi()["paths"]:
        assert f"`GET {path}" in PAGE or f"`POST {path}" in PAGE or f"`GET {path}`" in PAGE, path
