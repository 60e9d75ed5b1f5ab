"""What docs/protocol.md says, tried out."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from motionsplice.service.answers.batch import COLUMNS
from motionsplice.service.characters.commands import KEYS, NEEDED
from motionsplice.service.problems import PROBLEMS
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


def test_its_batch_is_answered(hands_client: TestClient) -> None:
    (batch,) = re.findall(r"```json\n({\"clips\".*?)```", PAGE, re.DOTALL)
    told = hands_client.post("/v1/poses", json=json.loads(batch.replace("directions", "counting"))).json()
    shown, bare, walk = told["rotations"]
    assert shown != bare
    assert shown != walk
    assert bare != walk


def test_it_names_every_parameter_column_and_command(service: Running) -> None:
    named = {one["name"] for path in ("pose", "splice", "stream") for one in parameters(service, path)}
    for name in {*named, *KEYS, *COLUMNS}:
        assert f"`{name}`" in PAGE or f'"{name}"' in PAGE, name
    for command in NEEDED:
        assert f'{{"do": "{command}"' in PAGE, command


def parameters(service: Running, path: str) -> list[dict[str, str]]:
    return service.config.front.app.openapi()["paths"][f"/v1/{path}"]["get"]["parameters"]


def test_it_names_every_problem() -> None:
    for status, kind in set(PROBLEMS.values()):
        assert re.search(rf"\|[ \d,]*{status}[ \d,]*\|[^|]*`{kind}`", PAGE), (status, kind)


def test_it_names_every_operation(service: Running) -> None:
    for path in service.config.front.app.openapi()["paths"]:
        assert f"`GET {path}" in PAGE or f"`POST {path}" in PAGE or f"`GET {path}`" in PAGE, path
