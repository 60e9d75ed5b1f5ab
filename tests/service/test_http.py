from __future__ import annotations

import gzip
import json
import logging
import re
import threading
import time
from typing import Any

import numpy as np
import pytest
from fastapi.openapi.models import OpenAPI
from fastapi.testclient import TestClient

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from motionsplice.service import caching, serving
from motionsplice.service.app import create_app
from motionsplice.service.models import BankInfo
from motionsplice.service.settings import Settings
from tests.service.running import Running, received


def test_the_bank_and_its_clips_are_listed(client: TestClient, bank: Bank) -> None:
    body = client.get("/v1/bank").json()
    assert body["digest"] == bank.digest
    assert {table["name"] for table in body["tables"]} == set(bank.tables)
    skeleton = client.get("/v1/skeleton").json()
    assert skeleton["joints"] == list(bank.skeleton.names)
    assert skeleton["parents"][0] == -1
    assert skeleton["roles"]["pelvis"] == bank.skeleton.names[bank.roles.pelvis]
    np.testing.assert_allclose(skeleton["offsets"], bank.skeleton.offsets, atol=1e-7)
    unreal = client.get("/v1/skeleton?axes=unreal").json()
    np.testing.assert_allclose(np.array(unreal["offsets"])[:, 2], 100.0 * bank.skeleton.offsets[:, 1], atol=1e-7)
    clips = client.get("/v1/clips").json()
    assert [clip["name"] for clip in clips] == [clip.name for clip in bank.clips]
    box = client.get("/v1/clips/carry_box").json()
    assert (box["kind"], box["neutral"], box["tags"]) == ("action", "walk", ["carry"])


def test_a_clip_lists_when_its_feet_stand(client: TestClient, bank: Bank) -> None:
    clips = {clip["name"]: clip for clip in client.get("/v1/clips").json()}
    assert client.get("/v1/clips/walk").json() == clips["walk"]
    for name, body in clips.items():
        feet = body["contacts"]
        found = sorted((down, foot, up) for foot in ("left", "right") for down, up in feet[foot])
        wanted = [(one.down, one.foot, one.up) for one in bank.contacts(name)]
        assert [one[1] for one in found] == [one[1] for one in wanted]
        np.testing.assert_allclose([one[::2] for one in found], [one[::2] for one in wanted], atol=1e-4)
    assert len(clips["walk"]["contacts"]["left"]) >= 4


def test_a_mirror_image_is_asked_for_by_its_name(client: TestClient, bank: Bank) -> None:
    query = "locomotion=walk&action=wave~mirror&time=1.2"
    found = client.get(f"/v1/pose?{query}").json()
    expected = Evaluator(bank).pose(Splice("walk", "wave~mirror"), 1.2)
    np.testing.assert_allclose(found["rotations"], expected.rotations[0], atol=1e-6)
    batch = {"clips": ["walk", "wave~mirror"], "locomotion": [0], "action": [1], "time": [1.2]}
    assert client.post("/v1/poses?format=json", json=batch).json()["rotations"] == [found["rotations"]]
    image, own = (client.get(f"/v1/clips/{name}").json() for name in ("walk~mirror", "walk"))
    assert image["contacts"]["left"] == own["contacts"]["right"]
    assert client.get("/v1/pose?locomotion=walk~miror&time=0").json()["status"] == 404


def test_the_service_states_its_protocol_and_limits(client: TestClient, bank: Bank) -> None:
    body = client.get("/v1/server").json()
    assert (body["bank"], body["ready"], body["uploads"]) == (bank.digest, True, False)
    assert body["protocol"] == 3
    assert [axes["name"] for axes in body["axes"]] == ["gltf", "unity", "unreal", "godot", "blender"]
    assert body["axes"][1]["description"] == "left-handed, Y up, Z forward"


def test_limits_are_whole_numbers_where_the_settings_are(client: TestClient) -> None:
    settings, limits = Settings(max_frames=5000), client.get("/v1/server").json()["limits"]
    for name, limit in limits.items():
        assert (limit, type(limit)) == (getattr(settings, name), type(getattr(settings, name)))
    assert (type(limits["max_frames"]), type(limits["max_load"]), type(limits["max_rate"])) == (int, int, float)
    document = client.get("/openapi.json").json()
    example = document["paths"]["/v1/server"]["get"]["responses"]["200"]["content"]["application/json"]["example"]
    assert example["limits"] == limits
    assert type(example["limits"]["max_frames"]) is int
    limit = document["components"]["schemas"]["ServerInfo"]["properties"]["limits"]["additionalProperties"]
    assert limit == {"anyOf": [{"type": "integer"}, {"type": "number"}]}


@pytest.mark.parametrize(
    ("path", "status", "kind", "words"),
    [
        ("/v1/clips/wlak", 404, "unknown-clip", "Did you mean 'walk'"),
        ("/v1/pose?locomotion=wlak&time=0", 404, "unknown-clip", "Did you mean 'walk'"),
        ("/v1/pose?locomotion=walk&time=0&action=wafe", 404, "unknown-clip", "Did you mean 'wave'"),
        ("/v1/pose?locomotion=walk&time=99", 422, "time-range", "Give a time from 0 to 5.000"),
        ("/v1/pose?locomotion=walk&time=-1", 422, "request", "time: "),
        ("/v1/pose?locomotion=walk&time=nan", 422, "request", "time: "),
        ("/v1/pose?locomotion=walk&time=soon", 422, "request", "time: "),
        ("/v1/pose?locomotion=walk", 422, "request", "time: "),
        ("/v1/pose?locomotion=walk&time=0&method=splise", 422, "request", "method: "),
        ("/v1/pose?locomotion=walk&time=0&posture=upright", 422, "request", "posture: "),
        ("/v1/pose?locomotion=walk&time=0&action=wave&posture=running", 422, "request", "absolute, off, found"),
        ("/v1/pose?locomotion=walk&time=0&posture=running", 422, "request", "absolute, off, found"),
        ("/v1/pose?locomotion=walk&time=0&action=wave&start=9", 422, "time-range", "start 9.0 s lies outside"),
        ("/v1/pose?locomotion=walk&time=0&acton=wave", 422, "request", "Did you mean 'action'"),
        ("/v1/splice?locomotion=walk&acton=wave", 422, "request", "Did you mean 'action'"),
        ("/v1/skeleton?axis=unity", 422, "request", "Did you mean 'axes'"),
        ("/v1/clips?name=walk", 422, "request", "This request has no parameters"),
        ("/v1/splice?locomotion=wlak", 404, "unknown-clip", "Did you mean 'walk'"),
        ("/v1/splice?locomotion=walk&rate=0", 422, "request", "rate: "),
        ("/v1/splice?locomotion=walk&rate=1e9", 422, "request", "rate: "),
        ("/v1/splice?locomotion=walk&rate=100&action=wave&start=9", 422, "time-range", "start 9.0 s"),
        ("/v1/splice?locomotion=turn_180&rate=1000", 422, "limit", "exceed the 5000 frames"),
        ("/v1/splice?locomotion=walk&first=301", 422, "request", "first: frame 301 is after the last, 300"),
        ("/v1/splice?locomotion=walk&format=bvh&axes=unity", 422, "request", "Leave out axes and parts"),
        ("/v1/splice?locomotion=walk&format=xml", 422, "request", "format: "),
        ("/v1/stream?locomotion=walk&ahead=121", 422, "limit", "ahead: 121 is more than 120"),
        ("/v1/stream?locomotion=walk&rate=500&pace=realtime", 422, "limit", "rate: 500 is more than 120"),
        ("/v1/tables/lowe", 404, "unknown-bank", "Did you mean 'lower'"),
        ("/v1/tables/..%2Fmanifest.msgpack", 404, "http", "no such path '/v1/tables/../manifest"),
        ("/v1/banks/00ff/pose?locomotion=walk&time=0", 404, "unknown-bank", "the bank '00ff' is not served"),
        ("/v1/nothing", 404, "http", "no such path '/v1/nothing'. GET /openapi.json lists all"),
        ("/v1/skeleton/", 404, "http", "no such path '/v1/skeleton/'. Use '/v1/skeleton'"),
        ("/v1//clips/walk", 404, "http", "no such path '/v1//clips/walk'. Use '/v1/clips/walk'"),
        ("/v1/poses/", 404, "http", "no such path '/v1/poses/'. Use '/v1/poses'"),
        ("/static-offline-docs", 404, "http", "no such path '/static-offline-docs'. GET /openapi.json"),
    ],
)
def test_errors_are_problems_that_say_what_to_do(
    client: TestClient, path: str, status: int, kind: str, words: str
) -> None:
    answer = client.get(path)
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert words in problem["detail"]
    assert (answer.status_code, problem["status"], problem["type"]) == (status, status, f"urn:motionsplice:{kind}")
    assert problem["request_id"] == answer.headers["x-request-id"]


@pytest.mark.parametrize("path", ["/healthz", "/readyz", "/metrics", "/v1/server", "/v1/pose?locomotion=walk&time=1"])
def test_a_head_request_is_answered_as_a_get_without_the_body(service: Running, path: str) -> None:
    whole = received(service.connect(f"GET {path} HTTP/1.0\r\nHost: localhost\r\n\r\n".encode()))
    alone = received(service.connect(f"HEAD {path} HTTP/1.0\r\nHost: localhost\r\n\r\n".encode()))
    status = b"204" if path.endswith("z") else b"200"
    assert alone.split(b" ")[1] == whole.split(b" ")[1] == status
    assert alone.endswith(b"\r\n\r\n")


def test_a_compressed_body_is_refused_as_such(client: TestClient) -> None:
    headers = {"content-type": "application/json", "content-encoding": "gzip"}
    answer = client.post("/v1/poses", content=gzip.compress(b"{}"), headers=headers)
    assert answer.status_code == 415
    assert answer.json()["detail"] == "content encoding 'gzip' is not supported. Send the body uncompressed"


@pytest.mark.parametrize(
    "path",
    [
        "pose?locomotion=walk&time=1",
        "splice?locomotion=walk",
        "expectation?locomotion=walk&action=wave",
        "clips",
        "clips/walk",
        "skeleton?axes=unity",
        "manifest",
        "tables/lower",
    ],
)
def test_answers_below_the_digest_of_the_bank_can_be_cached_for_ever(client: TestClient, bank: Bank, path: str) -> None:
    below = client.get(f"/v1/banks/{bank.digest}/{path}")
    assert below.headers["cache-control"] == "public, max-age=31536000, immutable"
    tag = below.headers["etag"]
    assert client.get(f"/v1/{path}").content == below.content
    for known in (tag, f"W/{tag}", f'"other", {tag}', "*"):
        again = client.get(f"/v1/banks/{bank.digest}/{path}", headers={"if-none-match": known})
        assert (again.status_code, again.content) == (304, b"")
        assert again.headers["etag"] == tag
    assert client.get(f"/v1/banks/{bank.digest}/{path}", headers={"if-none-match": '"other"'}).status_code == 200


@pytest.mark.parametrize("path", ["splice?locomotion=walk", "clips", "tables/lower"])
def test_answers_without_the_digest_must_be_revalidated(client: TestClient, path: str) -> None:
    plain = client.get(f"/v1/{path}")
    assert plain.headers["cache-control"] == "no-cache"
    again = client.get(f"/v1/{path}", headers={"if-none-match": plain.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_another_version_of_the_service_has_other_tags(
    client: TestClient, bank: Bank, monkeypatch: pytest.MonkeyPatch
) -> None:
    for path in ("/v1/splice?locomotion=walk", "/v1/clips", "/v1/clips/walk"):
        tag = client.get(path).headers["etag"]
        assert bank.digest in tag
        with monkeypatch.context() as later:
            later.setattr(caching, "__version__", "999.0")
            answer = client.get(path, headers={"if-none-match": tag})
        assert (answer.status_code, answer.headers["etag"]) == (200, f'"{bank.digest}-999.0"')


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("splice?locomotion=NOPE", 404),
        ("splice?locomotion=walk&first=9999", 422),
        ("splice?locomotion=walk&format=bvh&axes=unity", 422),
        ("expectation?locomotion=walk&action=wafe", 404),
        ("pose?locomotion=walk&time=99", 422),
        ("clips/wlak", 404),
        ("clips?name=walk", 422),
        ("skeleton?axes=maya", 422),
        ("tables/lowe", 404),
    ],
)
def test_what_would_be_refused_is_not_unchanged(client: TestClient, bank: Bank, path: str, status: int) -> None:
    tag = client.get("/v1/clips").headers["etag"]
    for known in (tag, "*"):
        answer = client.get(f"/v1/banks/{bank.digest}/{path}", headers={"if-none-match": known})
        assert answer.status_code == answer.json()["status"] == status
        assert "etag" not in answer.headers


def test_errors_are_not_cached(client: TestClient, bank: Bank) -> None:
    for path in ("pose?locomotion=wlak&time=1", "clips/wlak", "tables/lowe"):
        assert "cache-control" not in client.get(f"/v1/banks/{bank.digest}/{path}").headers


def test_tables_are_the_banks_files(client: TestClient, bank: Bank) -> None:
    assert client.get("/v1/manifest").content == (bank.path / "manifest.msgpack").read_bytes()
    for name, file in bank.files.items():
        whole = file.read_bytes()
        assert client.get(f"/v1/tables/{name}").content == whole
        part = client.get(f"/v1/tables/{name}", headers={"range": "bytes=100-199"})
        assert (part.status_code, part.content) == (206, whole[100:200])
        assert client.head(f"/v1/tables/{name}").headers["content-length"] == str(len(whole))


@pytest.mark.parametrize(("wanted", "status"), [("bytes=999999999-", 416), ("bytes=a-b", 400), ("lines=1-2", 400)])
def test_a_range_that_cannot_be_answered_is_a_problem(client: TestClient, bank: Bank, wanted: str, status: int) -> None:
    answer = client.get("/v1/tables/lower", headers={"range": wanted})
    assert (answer.status_code, answer.json()["status"], answer.json()["type"]) == (
        status, status, "urn:motionsplice:http"
    )  # fmt: skip
    size = bank.files["lower"].stat().st_size
    assert answer.headers.get("content-range") == (f"bytes */{size}" if status == 416 else None)


def test_it_is_alive_at_once_and_ready_when_the_kernels_are_compiled(
    bank: Bank, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled = threading.Event()
    monkeypatch.setattr(Evaluator, "warm", lambda _: compiled.wait(30))
    with TestClient(create_app(bank)) as client:
        assert client.get("/healthz").status_code == 204
        assert client.get("/readyz").status_code == 503
        answer = client.get("/v1/pose?locomotion=walk&time=0")
        assert (answer.status_code, answer.json()["type"]) == (503, "urn:motionsplice:not-ready")
        assert client.get("/v1/clips").status_code == 200
        compiled.set()
        deadline = time.monotonic() + 30.0
        while client.get("/readyz").status_code == 503:
            assert time.monotonic() < deadline
        assert client.get("/v1/pose?locomotion=walk&time=0").status_code == 200


def test_the_log_says_that_kernels_are_being_compiled(
    bank: Bank, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    compiled = threading.Event()
    caplog.set_level(logging.INFO)
    monkeypatch.setattr(Evaluator, "warm", lambda _: compiled.wait(30))
    monkeypatch.setattr(serving, "CACHED_SECONDS", 0.01)
    with TestClient(create_app(bank)) as client:
        deadline = time.monotonic() + 30.0
        while "the kernels are being compiled" not in caplog.text:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        compiled.set()
        wait_until_ready(client)
    messages = [record.message.partition(",")[0] for record in caplog.records if "." in record.name]
    logged = [one for one in messages if one in ("starting", "the kernels are being compiled", "ready", "stopping")]
    assert logged == ["starting", "the kernels are being compiled", "ready", "stopping"]


def test_kernels_that_cannot_be_compiled_are_reported(
    bank: Bank, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def warm(_: Evaluator) -> None:
        raise RuntimeError("no compiler here")

    monkeypatch.setattr(Evaluator, "warm", warm)
    with TestClient(create_app(bank)) as client:
        deadline = time.monotonic() + 30.0
        while "could not be compiled" not in client.get("/readyz").json()["detail"]:
            assert time.monotonic() < deadline
        assert client.get("/v1/splice?locomotion=walk").status_code == 503
        assert client.get("/healthz").status_code == 204
    assert "no compiler here" in caplog.text


def test_a_failure_of_the_service_is_a_problem_too(
    bank: Bank, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*_: Any) -> None:
        raise RuntimeError("secret")

    monkeypatch.setattr(BankInfo, "of", fail)
    answer = TestClient(create_app(bank), raise_server_exceptions=False).get("/v1/bank")
    assert (answer.status_code, answer.json()["type"]) == (500, "urn:motionsplice:failure")
    assert answer.headers["content-type"] == "application/problem+json"
    assert "secret" not in answer.text
    assert "secret" in caplog.text


def test_a_refused_method_lists_the_allowed_ones(client: TestClient) -> None:
    answer = client.post("/v1/bank")
    assert answer.status_code == answer.json()["status"] == 405
    assert answer.headers["allow"] == "GET, HEAD"
    assert client.head("/v1/job/events").headers.get("allow") == "GET"


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("POST", "/v1/pose", "GET, HEAD"),
        ("DELETE", "/v1/pose?locomotion=walk&time=0", "GET, HEAD"),
        ("GET", "/v1/poses", "POST"),
        ("GET", "/v1/take", "POST"),
        ("POST", "/v1/splice", "GET, HEAD"),
        ("PUT", "/v1/expectation", "GET, HEAD"),
        ("HEAD", "/v1/stream?locomotion=walk", "GET"),
        ("HEAD", "/v1/poses", "POST"),
        ("OPTIONS", "/v1/stream", "GET"),
    ],
)
def test_a_refused_method_of_a_direct_route_does_too(client: TestClient, method: str, path: str, allowed: str) -> None:
    answer = client.request(method, path)
    assert (answer.status_code, answer.headers["allow"]) == (405, allowed)
    if method != "HEAD":
        assert answer.json()["type"] == "urn:motionsplice:http"
        assert answer.json()["detail"].endswith(
            f"does not have the method {method}. Use {allowed.removesuffix(', HEAD')}"
        )


def test_the_head_of_a_pose_is_that_of_its_get(client: TestClient) -> None:
    for path in ("/v1/pose?locomotion=walk&time=1", "/v1/splice?locomotion=walk"):
        head, got = client.head(path), client.get(path)
        assert (head.status_code, head.headers["content-length"]) == (200, str(len(got.content)))
        assert head.headers["content-type"] == got.headers["content-type"]


@pytest.mark.parametrize("method", ["GET", "POST"])
def test_a_plain_request_to_the_websocket_says_so(client: TestClient, method: str) -> None:
    answer = client.request(method, "/v1/characters?rate=60")
    assert (answer.status_code, answer.json()["type"]) == (426, "urn:motionsplice:http")
    assert "Connect with a WebSocket" in answer.json()["detail"]
    assert answer.headers["upgrade"] == "websocket"


def test_too_many_streams_are_refused(bank: Bank, monkeypatch: pytest.MonkeyPatch) -> None:
    front = create_app(bank, Settings(max_streams=1))
    with TestClient(front) as client:
        wait_until_ready(client)
        with front.shared.admitted():
            for path in ("stream", "splice"):
                answer = client.get(f"/v1/{path}?locomotion=walk")
                assert (answer.status_code, answer.json()["type"]) == (429, "urn:motionsplice:busy")
        assert client.get("/v1/stream?locomotion=walk").status_code == 200
        assert not front.shared.streams


@pytest.mark.parametrize("path", ["/docs", "/redoc"])
def test_the_documentation_needs_no_other_host_and_no_path_of_its_own(client: TestClient, path: str) -> None:
    page = client.get(path)
    assert page.headers["content-security-policy"].startswith("default-src 'self'")  # Redoc asks for a logo elsewhere
    sources = re.findall(r"""(?:src|href|spec-url)=["']([^"']+)|url: '([^']+)""", page.text)
    assert len(sources) >= 3
    for source in map("".join, sources):
        assert not source.startswith(("/", "http"))  # a proxy may serve the page below another path
        assert client.get(f"/{source}").status_code == 200
    assert client.get("/openapi.json").json()["servers"] == [{"url": "."}]


@pytest.mark.parametrize("path", ["/", "/view", "/view?locomotion=walk"])
def test_a_redirect_keeps_the_scheme_and_path_of_a_proxy(client: TestClient, path: str) -> None:
    answer = client.get(path, follow_redirects=False)
    assert answer.status_code == 307
    assert answer.headers["location"] == f"view/{path.removeprefix('/view').removeprefix('/')}"


def test_the_schema_names_every_operation_and_its_problems(client: TestClient) -> None:
    document = client.get("/openapi.json").json()
    OpenAPI.model_validate(document)
    assert set(document["paths"]) >= {
        "/v1/server", "/v1/bank", "/v1/skeleton", "/v1/clips", "/v1/clips/{name}", "/v1/pose", "/v1/poses",
        "/v1/splice", "/v1/expectation", "/v1/stream", "/v1/take", "/v1/job", "/v1/job/events", "/v1/manifest",
        "/v1/tables/{name}", "/healthz", "/readyz", "/metrics",
    }  # fmt: skip
    names = {one["name"] for one in document["paths"]["/v1/pose"]["get"]["parameters"]}
    assert names == {
        "locomotion", "time", "action", "start", "method", "posture", "hands", "axes", "parts", "encoding", "format",
    }  # fmt: skip
    references = set(re.findall(r'"#/components/schemas/(\w+)"', json.dumps(document)))
    assert references <= set(document["components"]["schemas"])
    for path, operations in document["paths"].items():
        for operation in operations.values():
            assert operation["summary"], path
            assert operation["description"], path
            for status, answer in operation["responses"].items():
                if status >= "400":
                    assert "application/problem+json" in answer["content"], path


def test_the_examples_of_the_interactive_page_are_answered(client: TestClient) -> None:
    for path, operations in client.get("/openapi.json").json()["paths"].items():
        if path in ("/v1/job", "/v1/job/events", "/v1/report"):  # settings that this service does not have
            continue
        for method, operation in operations.items():
            if (method, path) == ("post", "/v1/clips"):
                continue
            filled = {one["name"]: one["example"] for one in operation.get("parameters", []) if "example" in one}
            body = operation.get("requestBody", {}).get("content", {}).get("application/json", {}).get("example")
            query = {name: value for name, value in filled.items() if f"{{{name}}}" not in path}
            answer = client.request(method, path.format_map(filled), params=query, json=body)
            assert answer.is_success, (path, answer.text)


def wait_until_ready(client: TestClient) -> None:
    deadline = time.monotonic() + 60.0
    while client.get("/readyz").status_code == 503:
        assert time.monotonic() < deadline
        time.sleep(0.01)
