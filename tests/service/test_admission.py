from __future__ import annotations

import json
from typing import Any

import pytest
from fastapi.testclient import TestClient
from pydantic import SecretStr
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.service.admission import Admission
from motionsplice.service.app import create_app
from motionsplice.service.problems import OriginError
from motionsplice.service.settings import Settings
from tests.service.characters.player import Player
from tests.service.running import PATIENCE, Running, eventually, running

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
        url, wrong = (
            f"ws://127.0.0.1:{service.port}/v1/characters",
            [Subprotocol("motionsplice"), Subprotocol("bearer.no")],
        )
        with connect(url, subprotocols=wrong) as socket:
            assert json.loads(socket.recv(timeout=PATIENCE))["type"] == "urn:motionsplice:token"


@pytest.mark.parametrize(
    ("origin", "status"), [(None, 200), (PAGE, 200), ("http://testserver", 200), ("https://evil.example", 403)]
)
def test_only_allowed_origins_are_answered(guarded: TestClient, origin: str | None, status: int) -> None:
    headers = {"authorization": f"Bearer {TOKEN}"} | ({"origin": origin} if origin else {})
    answer = guarded.get("/v1/bank", headers=headers)
    assert answer.status_code == status
    assert answer.headers.get("access-control-allow-origin") == origin  # of a refusal too, so that the page can read it
    preflight = {"origin": PAGE, "access-control-request-method": "POST"}
    answer = guarded.options("/v1/poses", headers=preflight)
    assert answer.status_code == 204
    assert answer.headers["access-control-allow-origin"] == PAGE
    assert guarded.options("/v1/poses", headers={**preflight, "origin": "https://evil.example"}).status_code == 403


@pytest.mark.parametrize("path", ["pose?locomotion=walk&time=1", "clips", "tables/lower"])
def test_a_cache_that_an_engine_fills_serves_no_page(guarded: TestClient, bank: Bank, path: str) -> None:
    token, url = {"authorization": f"Bearer {TOKEN}"}, f"/v1/banks/{bank.digest}/{path}"
    eventually(lambda: guarded.get("/readyz").status_code == 204)
    for headers in (token, token | {"origin": PAGE}):
        answer = guarded.get(url, headers=headers)
        again = guarded.get(url, headers=headers | {"if-none-match": answer.headers["etag"]})
        assert (answer.status_code, again.status_code) == (200, 304)
        assert answer.headers["vary"] == again.headers["vary"] == "origin"


def test_settings_do_not_reveal_the_token() -> None:
    assert TOKEN not in repr(Settings(token=SecretStr(TOKEN)))
    with pytest.raises(SettingsError, match="MOTIONSPLICE_TOKEN is too short") as caught:
        Settings(token=SecretStr("shorty"))
    assert "shorty" not in str(caught.value)


OWN = "http://127.0.0.1:8000"


@pytest.mark.parametrize(
    ("host", "token", "asked", "origin", "allowed"),
    [
        ("127.0.0.1", None, "127.0.0.1:8000", "http://localhost:3000", True),
        ("127.0.0.1", None, "localhost:8000", "http://127.0.0.1:5173", True),
        ("127.0.0.1", None, "[::1]:8000", "https://[::1]", True),
        ("::1", None, "[::1]:8000", "http://localhost", True),
        ("127.0.0.1", None, "127.0.0.1:8000", OWN, True),
        ("127.0.0.1", None, "127.0.0.1:8000", "null", False),
        ("127.0.0.1", None, "127.0.0.1:8000", "http://localhost.evil.example", False),
        ("127.0.0.1", None, "127.0.0.1:8000", "http://localhost:3000.evil.example", False),
        ("127.0.0.1", None, "127.0.0.1:8000", "http://evil.example/?http://localhost", False),
        ("127.0.0.1", None, "127.0.0.1:8000", "file://localhost", False),
        ("127.0.0.1", None, "evil.example:8000", "http://evil.example:8000", False),  # DNS rebinding
        ("127.0.0.1", None, "evil.example:8000", "http://localhost:3000", False),
        ("127.0.0.1", TOKEN, "studio.example", "https://studio.example", True),  # a proxy on the same machine
        ("0.0.0.0", None, "127.0.0.1:8000", "http://localhost:3000", False),
        ("0.0.0.0", None, "studio.example:8000", "http://studio.example:8000", True),
    ],
)
def test_local_pages_may_connect_to_a_local_service_by_a_local_name(
    host: str, token: str | None, asked: str, origin: str, allowed: bool
) -> None:
    admission = Admission(Settings(host=host, token=SecretStr(token) if token else None))
    headers = [(b"origin", origin.encode()), (b"host", asked.encode()), (b"authorization", f"Bearer {token}".encode())]
    scope = {"headers": headers, "path": "/v1/characters"}
    if allowed:
        admission.check(scope)
    else:
        with pytest.raises(OriginError, match="are not allowed"):
            admission.check(scope)


def test_a_page_on_localhost_plays_characters(service: Running) -> None:
    with Player(service, origin=Origin("http://localhost:3000")) as player:
        assert player.do({"do": "create", "id": 1, "locomotion": "walk"})["event"] == "done"


@pytest.mark.parametrize(
    ("path", "origin", "code", "kind", "words"),
    [
        ("?rate=60", "https://evil.example", 4403, "origin", "'https://evil.example' are not allowed. Add it to"),
        ("?rate=200", "http://localhost", 4422, "limit", "rate: 200 is more than 120"),
        ("?axis=unity", "http://localhost", 4422, "request", "Did you mean 'axes'"),
        ("/nothing", "http://localhost", 4404, "http", "Connect to /v1/characters"),
        ("?rate=0", None, 4422, "request", "rate: expected a number from 1 to 1000, found '0'"),
        ("/nothing", None, 4404, "http", "Connect to /v1/characters"),
    ],
)
@pytest.mark.parametrize("subprotocols", [None, ["motionsplice", "bearer.wrong"]])
def test_a_client_can_read_why_its_websocket_is_refused(
    service: Running, path: str, origin: str | None, code: int, kind: str, words: str, subprotocols: Any
) -> None:
    url = f"ws://127.0.0.1:{service.port}/v1/characters{path}"
    with connect(url, origin=None if origin is None else Origin(origin), subprotocols=subprotocols) as socket:
        event = json.loads(socket.recv(timeout=PATIENCE))
        assert (event["event"], event["ref"], event["type"]) == ("refused", None, f"urn:motionsplice:{kind}")
        assert words in event["detail"]
        with pytest.raises(ConnectionClosed) as caught:
            socket.recv(timeout=PATIENCE)
        assert caught.value.rcvd is not None
        assert (caught.value.rcvd.code, caught.value.rcvd.reason) == (code, kind)
    eventually(lambda: service.held == (0, 0, 0, 0))


def test_a_page_can_read_that_its_token_is_wrong(guarded: TestClient) -> None:
    answer = guarded.get("/v1/bank", headers={"origin": PAGE})
    assert (answer.status_code, answer.headers["access-control-allow-origin"]) == (401, PAGE)
