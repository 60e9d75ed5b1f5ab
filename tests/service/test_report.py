"""The report of quality that the service shows: a file of `bench.quality`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.settings import Settings
from tests.reports import report_of


def client_of(bank: Bank, report: Path | None) -> TestClient:
    return TestClient(create_app(bank, Settings(report=report)))


def refusal(client: TestClient) -> str:
    answer = client.get("/v1/report")
    assert (answer.status_code, answer.json()["type"]) == (404, "urn:motionsplice:report")
    assert client.get("/v1/server").json()["report"] in (True, False)
    detail: str = answer.json()["detail"]
    return detail


def test_a_report_is_served_as_it_was_written(bank: Bank, tmp_path: Path) -> None:
    file = tmp_path / "scores.json"
    file.write_text(json.dumps(report_of(bank)))
    client = client_of(bank, file)
    answer = client.get("/v1/report")
    assert answer.headers["content-type"] == "application/json"
    assert answer.json() == {key: value for key, value in json.loads(file.read_text()).items() if key != "clips"}
    assert client.get("/v1/server").json()["report"] is True


def test_a_service_without_a_report_says_how_to_make_one(bank: Bank) -> None:
    client = client_of(bank, None)
    assert "python -m bench.quality --bank BANK" in refusal(client)
    assert client.get("/v1/server").json()["report"] is False


def test_a_report_may_come_and_change_while_the_service_runs(bank: Bank, tmp_path: Path) -> None:
    file = tmp_path / "scores.json"
    client = client_of(bank, file)
    detail = refusal(client)
    assert "scores.json" in detail
    assert str(tmp_path) not in detail  # clients do not see the folders of the machine
    assert client.get("/v1/server").json()["report"] is False
    report = report_of(bank)
    file.write_text(json.dumps(report))
    assert len(client.get("/v1/report").json()["pairs"]) == len(report["pairs"])
    file.write_text(json.dumps({**report, "pairs": []}))
    assert client.get("/v1/report").json()["pairs"] == []


def damaged(report: dict[str, Any]) -> dict[str, str]:
    without_bank = {key: value for key, value in report.items() if key != "bank"}
    return {"bank: Field required": json.dumps(without_bank), "JSON": "{", ": Input should be an object": "[]"}


def test_a_file_that_is_not_a_report_is_refused(bank: Bank, tmp_path: Path) -> None:
    file = tmp_path / "scores.json"
    client = client_of(bank, file)
    for wrong, text in damaged(report_of(bank)).items():
        file.write_text(text)
        detail = refusal(client)
        assert "scores.json: not a report of bench.quality" in detail
        assert wrong in detail


@pytest.mark.parametrize("path", ["/view/report", "/view/report.html"])
def test_the_page_is_served(client: TestClient, path: str) -> None:
    page = client.get(path)
    assert page.status_code == 200
    assert "report/main.js" in page.text
    assert "'unsafe" not in page.headers["content-security-policy"]
