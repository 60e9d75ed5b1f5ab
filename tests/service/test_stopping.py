"""What clients get for requests that are open when the service stops."""

from __future__ import annotations

import asyncio
import json
import logging
import shutil
import threading
from pathlib import Path
from typing import Any, NoReturn

import pytest
from fastapi.testclient import TestClient
from pydantic import SecretStr

from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.exchange import uploads
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from tests.service.running import PATIENCE, Running, eventually, received, running

TOKEN = "open-sesame"
HEAD = f"Host: localhost\r\nAuthorization: Bearer {TOKEN}\r\nContent-Length: 1000\r\n"


def is_refused(answer: bytes) -> bool:
    head, _, body = answer.partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 503 ")
    assert b"connection: close" in head
    assert b"application/problem+json" in head
    document: dict[str, Any] = json.loads(body)
    return document["type"] == "urn:motionsplice:not-ready" and "stopping" in document["detail"]


@pytest.fixture
def settings(clip_folder: Path, tmp_path: Path) -> Settings:
    shutil.copytree(clip_folder, tmp_path / "clips")
    return Settings(token=SecretStr(TOKEN), clips=tmp_path / "clips", stop_seconds=60.0)


def stop_with_open(service: Running, sent: bytes) -> bytes:
    """Sends the beginning of a request, and stops the service. Returns the answer."""
    peer = service.connect(sent)
    eventually(lambda: len(service.server.server_state.tasks) == 1)
    service.server.should_exit = True
    return received(peer)


@pytest.mark.parametrize("path", ["/v1/poses", "/v1/take", "/v1/clips?name=jump.bvh"])
def test_a_body_that_is_arriving_is_refused_at_once(
    bank: Bank, settings: Settings, caplog: pytest.LogCaptureFixture, path: str
) -> None:
    with running(bank.path, settings) as service, caplog.at_level(logging.INFO):
        logging.getLogger().addHandler(caplog.handler)  # the service has configured the log anew
        head = f"POST {path} HTTP/1.1\r\n{HEAD}Content-Type: application/json\r\n\r\n{{"
        assert is_refused(stop_with_open(service, head.encode()))
    (line,) = [record for record in caplog.records if record.message == "refused"]
    assert (line.status, line.path) == (503, path.partition("?")[0])  # type: ignore[attr-defined]
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]


def test_what_is_not_done_in_time_is_refused_without_a_traceback(
    bank: Bank, settings: Settings, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def check(*_: Any) -> None:
        await asyncio.sleep(3600.0)

    monkeypatch.setattr(uploads, "_check", check)
    with running(bank.path, settings.model_copy(update={"stop_seconds": 0.2})) as service:
        logging.getLogger().addHandler(caplog.handler)
        head = f"POST /v1/clips?name=jump.bvh HTTP/1.1\r\n{HEAD}\r\n".encode()
        assert is_refused(stop_with_open(service, head + 1000 * b"x"))
    assert not [record for record in caplog.records if record.exc_info]


def test_a_stream_that_is_cut_is_no_error_in_the_log(bank: Bank, caplog: pytest.LogCaptureFixture) -> None:
    with running(bank.path, Settings()) as service:
        logging.getLogger().addHandler(caplog.handler)
        head = "GET /v1/stream?locomotion=walk&pace=realtime HTTP/1.1\r\nHost: localhost\r\n\r\n"
        answer = stop_with_open(service, head.encode())
    assert answer.startswith(b"HTTP/1.1 200 ")
    assert not answer.endswith(b"\r\n0\r\n\r\n")
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]


def test_a_service_that_still_compiles_ends_at_once(bank: Bank, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled, goes_on = threading.Event(), threading.Event()

    def compile_for_long(_: Bank) -> NoReturn:
        goes_on.wait(PATIENCE)
        compiled.set()
        raise AssertionError

    monkeypatch.setattr(Edition, "warm", compile_for_long)
    with TestClient(create_app(bank, Settings())) as client:
        assert client.get("/readyz").status_code == 503
    assert not compiled.is_set()
    goes_on.set()
    assert compiled.wait(PATIENCE)
