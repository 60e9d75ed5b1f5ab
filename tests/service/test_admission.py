from __future__ import annotations

from typing import Any

import pytest
from fastapi.testclient import TestClient
from pydantic import SecretStr
from websockets.exceptions import InvalidStatus

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.settings import Settings
from tests.service.characters.player import Player
from tests.service.running import running

TOKEN = "open-sesame"
PAGE = "https://editor.example"


@pytest.fixture(scope="module")
def guarded(bank: Bank) -> Any:
    with TestClient(create_app(bank, Settings(token=SecretStr(TOKEN), origins=(PAGE,)))) as client:
        yield client


@pytest.mark.parametrize(
    "header",
    [{}, {"authorization": "Bearer wrong"}, {"authorization": f"Basic {TOKEN}"}, {"authorization": f"Bearer {TOKEN}x"}],
)
@pytest.mark.parametrize("path", ["/v1/bank", "/v1/pose?locomotion=walk&time=0", "/metrics", "/v1/nothing"])
def test_without_the_token_requests_are_refused(guarded: TestClient, path: str, header: dict[str, str]) -> None:
    answer = guarded.get(path, headers=header)
    assert (answer.status_code, answer.json()["type"]) == (401, "urn:motionsplice:token")
    assert answer.headers["www-authenticate"] == "Bearer"
    assert TOKEN not in answer.text


@pytest.mark.parametrize("path", ["/healthz", "/docs", "/openapi.json"])
def test_health_and_documentation_need_no_token(guarded: TestClient, path: str) -> None:
    assert guarded.get(path).is_success


def test_with_the_token_requests_are_answered_and_cached_privately(guarded: TestClient, bank: Bank) -> None:
    for name in ("Bearer", "bearer"):
        answer = guarded.get(f"/v1/banks/{bank.digest}/clips", headers={"authorization": f"{name} {TOKEN}"})
        assert answer.is_success
        assert answer.headers["cache-control"].startswith("private")


def test_a_browser_offers_the_token_as_a_subprotocol(bank: Bank) -> None:
    with running(bank.path, Settings(token=SecretStr(TOKEN))) as service:
        with Player(service, subprotocols=["motionsplice", f"bearer.{TOKEN}"]) as player:
            assert player.socket.subprotocol == "motionsplice"
            assert player.welcome["event"] == "welcome"
        with pytest.raises(InvalidStatus) as caught:
            Player(service, subprotocols=["motionsplice", "bearer.wrong"])
        assert caught.value.response.status_code == 401


@pytest.mark.parametrize(
    ("origin", "status"), [(None, 200), (PAGE, 200), ("http://testserver", 200), ("https://evil.example", 403)]
)
def test_only_allowed_origins_are_answered(guarded: TestClient, origin: str | None, status: int) -> None:
    headers = {"authorization": f"Bearer {TOKEN}"} | ({"origin": origin} if origin else {})
    answer = guarded.get("/v1/bank", headers=headers)
    assert answer.status_code == status
    assert answer.headers.get("access-control-allow-origin") == (origin if status == 200 else None)
    preflight = {"origin": PAGE, "access-control-request-method": "POST"}
    answer = guarded.options("/v1/poses", headers=preflight)
    assert answer.status_code == 204
    assert answer.headers["access-control-allow-origin"] == PAGE


def test_settings_do_not_reveal_the_token() -> None:
    assert TOKEN not in repr(Settings(token=SecretStr(TOKEN)))
    with pytest.raises(SettingsError, match="MOTIONSPLICE_TOKEN is too short") as caught:
        Settings(token=SecretStr("shorty"))
    assert "shorty" not in str(caught.value)
