from __future__ import annotations

import asyncio
import json
import re
import socket
import threading
import time
import urllib.request
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
import uvicorn
from fastapi.openapi.models import OpenAPI
from fastapi.testclient import TestClient

from motion.errors import SettingsError
from runtime.bank import Bank
from runtime.evaluator import Evaluator
from runtime.requests import Memory, Posture
from service import routes
from service.app import create_app
from service.models import BankInfo, StreamRequest
from service.settings import Settings
from service.stream import Clock, frame_times, messages

PROTOCOL = Path(__file__).parents[2] / "docs" / "protocol.md"


def unpacked(stream: bytes) -> list[dict[str, Any]]:
    """The messages of a length-delimited stream."""
    read = []
    while stream:
        size = int.from_bytes(stream[:4], "big")
        assert len(stream) >= 4 + size
        read.append(msgpack.unpackb(stream[4 : 4 + size]))
        stream = stream[4 + size :]
    return read


def test_the_bank_and_its_clips_are_told(client: TestClient, bank: Bank) -> None:
    told = client.get("/v1/bank").json()
    assert told["digest"] == bank.digest
    assert told["joints"] == list(bank.skeleton.names)
    assert told["parents"][0] == -1
    clips = client.get("/v1/clips").json()
    assert [clip["name"] for clip in clips] == [clip.name for clip in bank.clips]
    box = client.get("/v1/clips/carry_box").json()
    assert (box["kind"], box["neutral"], box["tags"]) == ("action", "walk", ["carry"])


@pytest.mark.parametrize("method", ["splice", "naive", "none"])
@pytest.mark.parametrize("posture", ["relative", "absolute", "off"])
def test_a_pose_is_the_evaluators(client: TestClient, bank: Bank, method: Any, posture: Any) -> None:
    query = f"locomotion=run&time=1.25&action=wave&start=0.5&method={method}&posture={posture}&world=true"
    answer = client.get(f"/v1/pose?{query}")
    assert answer.status_code == 200
    evaluator = Evaluator(bank)
    poses = evaluator.pose("run", 1.25, "wave", start=0.5, method=method, posture=posture)
    np.testing.assert_allclose(answer.json()["rotations"], poses.rotations[0], atol=1e-7)
    np.testing.assert_allclose(answer.json()["root_position"], poses.root_positions[0], atol=1e-7)
    world = np.empty((1, bank.skeleton.joint_count, 3), np.float32)
    evaluator.world_positions(poses, world)
    np.testing.assert_allclose(answer.json()["world_positions"], world[0], atol=1e-6)


def assert_is_the_evaluators(
    stream: bytes, bank: Bank, locomotion: str, action: str, posture: Posture = "relative"
) -> None:
    header, *frames = unpacked(stream)
    evaluator = Evaluator(bank)
    times = evaluator.frame_times(locomotion)
    memory = Memory.begin(1, bank.clip(locomotion).rate)
    poses = evaluator.sequence(locomotion, times, action, posture=posture, memory=memory)
    assert header["stream"] == 1
    assert header["bank"] == bank.digest
    assert (header["locomotion"], header["action"]) == (locomotion, action)
    assert header["rate"] == bank.clip(locomotion).rate
    assert header["joints"] == list(bank.skeleton.names)
    assert header["parents"] == bank.skeleton.parents.tolist()
    assert "Y up" in header["axes"]
    assert "metres" in header["units"]
    assert header["frames"] == len(frames) == len(times)
    assert [frame["frame"] for frame in frames] == list(range(len(times)))
    np.testing.assert_allclose([frame["time"] for frame in frames], times, rtol=0, atol=1e-12)
    rotations = np.array([np.frombuffer(frame["rotations"], "<f4").reshape(-1, 4) for frame in frames])
    roots = np.array([np.frombuffer(frame["root_position"], "<f4") for frame in frames])
    np.testing.assert_array_equal(rotations, poses.rotations)
    np.testing.assert_array_equal(roots, poses.root_positions)


def test_a_stream_is_the_evaluators_frames_to_the_bit(client: TestClient, bank: Bank) -> None:
    answer = client.get("/v1/splice?locomotion=run&action=carry_box")
    assert answer.headers["content-type"] == "application/vnd.motionsplice.stream"
    assert_is_the_evaluators(answer.content, bank, "run", "carry_box")


def test_a_stream_may_follow_its_own_posture(client: TestClient, bank: Bank) -> None:
    answer = client.get("/v1/splice?locomotion=run&action=carry_box&posture=running")
    assert_is_the_evaluators(answer.content, bank, "run", "carry_box", posture="running")


def test_a_stream_for_people_is_lines_of_json(client: TestClient, bank: Bank) -> None:
    query = "locomotion=walk&action=wave&format=json&rate=10"
    header, *frames = (json.loads(line) for line in client.get(f"/v1/splice?{query}").text.splitlines())
    assert header["rate"] == 10
    assert len(frames) == header["frames"] == int(bank.clip("walk").duration * 10) + 1
    poses = Evaluator(bank).pose("walk", frames[7]["time"], "wave")
    np.testing.assert_allclose(frames[7]["rotations"], poses.rotations[0], atol=1e-5)


def test_a_paced_stream_keeps_the_clips_time_without_drift(bank: Bank) -> None:
    request = StreamRequest(locomotion="walk", action="wave", pace="realtime")
    evaluator = Evaluator(bank)
    times = frame_times(evaluator, request, 10**6)
    now, sent, stream = 100.0, [], b""

    async def sleep(seconds: float) -> None:
        nonlocal now
        now += seconds + 0.003  # each wait is a little late, and lateness must not add up

    async def collect() -> None:
        nonlocal stream
        async for chunk in messages(evaluator, request, times, Clock(lambda: now, sleep)):
            sent.append(now - 100.0)
            stream += chunk

    asyncio.run(collect())
    late = np.array(sent[1:]) - times
    assert late.min() >= 0.0
    assert late.max() < 0.0031
    assert_is_the_evaluators(stream, bank, "walk", "wave")


def test_a_stream_waits_for_nothing_before_its_first_frame_and_yields_between_blocks(bank: Bank) -> None:
    request, evaluator = StreamRequest(locomotion="walk", rate=1000), Evaluator(bank)
    times = frame_times(evaluator, request, 10**6)
    yields = 0

    async def sleep(seconds: float) -> None:
        nonlocal yields
        assert seconds == 0.0
        yields += 1

    async def collect() -> list[bytes]:
        return [chunk async for chunk in messages(evaluator, request, times, Clock(lambda: 0.0, sleep))]

    chunks = asyncio.run(collect())
    assert yields == len(chunks) - 1 > 50
    assert max(map(len, chunks)) < 200_000


@pytest.mark.parametrize(
    ("path", "status", "words"),
    [
        ("/v1/clips/wlak", 404, "Did you mean 'walk'"),
        ("/v1/pose?locomotion=wlak&time=0", 404, "Did you mean 'walk'"),
        ("/v1/pose?locomotion=walk&time=0&action=wafe", 404, "Did you mean 'wave'"),
        ("/v1/pose?locomotion=walk&time=99", 422, "Give a time from 0 to 5.000"),
        ("/v1/pose?locomotion=walk&time=-1", 422, "time: "),
        ("/v1/pose?locomotion=walk&time=nan", 422, "time: "),
        ("/v1/pose?locomotion=walk&time=inf", 422, "time: "),
        ("/v1/pose?locomotion=walk&time=soon", 422, "time: "),
        ("/v1/pose?locomotion=walk", 422, "time: "),
        ("/v1/pose?locomotion=walk&time=0&method=splise", 422, "method: "),
        ("/v1/pose?locomotion=walk&time=0&posture=upright", 422, "posture: "),
        ("/v1/pose?locomotion=walk&time=0&action=wave&posture=running", 422, "ask for a whole clip"),
        ("/v1/pose?locomotion=walk&time=0&action=wave&start=9", 422, "start 9.0 s lies outside clip 'wave'"),
        ("/v1/pose?locomotion=walk&time=0&acton=wave", 422, "acton: "),
        ("/v1/splice?locomotion=walk&acton=wave", 422, "acton: "),
        ("/v1/splice?locomotion=wlak", 404, "Did you mean 'walk'"),
        ("/v1/splice?locomotion=walk&rate=0", 422, "rate: "),
        ("/v1/splice?locomotion=walk&rate=1e9", 422, "rate: "),
        ("/v1/splice?locomotion=walk&rate=100&action=wave&start=9", 422, "start 9.0 s"),
        ("/v1/splice?locomotion=turn_180&rate=1000", 422, "more than the 5000"),
        ("/v1/splice?locomotion=walk&format=xml", 422, "format: "),
        ("/v1/nothing", 404, "Not Found"),
    ],
)
def test_errors_are_problems_that_say_what_to_do(client: TestClient, path: str, status: int, words: str) -> None:
    answer = client.get(path)
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem["status"] == status
    assert words in problem["detail"]


def test_it_lives_at_once_and_is_ready_when_kernels_are_warm(bank: Bank, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = threading.Event()
    monkeypatch.setattr(Evaluator, "warm", lambda _: compiled.wait(30))
    with TestClient(create_app(bank)) as client:
        assert client.get("/healthz").status_code == 204
        assert client.get("/readyz").status_code == 503
        assert client.get("/v1/pose?locomotion=walk&time=0").status_code == 503
        assert client.get("/v1/clips").status_code == 200
        compiled.set()
        deadline = time.monotonic() + 30.0
        while client.get("/readyz").status_code == 503:
            assert time.monotonic() < deadline
        assert client.get("/readyz").status_code == 204
        assert client.get("/v1/pose?locomotion=walk&time=0").status_code == 200


def test_kernels_that_cannot_be_compiled_are_told(
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


def test_what_no_client_caused_is_a_problem_too(bank: Bank, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: Any) -> None:
        raise RuntimeError("secret")

    monkeypatch.setattr(BankInfo, "of", fail)
    answer = TestClient(create_app(bank), raise_server_exceptions=False).get("/v1/bank")
    assert (answer.status_code, answer.json()["status"]) == (500, 500)
    assert answer.headers["content-type"] == "application/problem+json"
    assert "secret" not in answer.text


def test_a_method_that_is_not_allowed_says_which_is(client: TestClient) -> None:
    answer = client.post("/v1/clips")
    assert answer.status_code == answer.json()["status"] == 405
    assert answer.headers["allow"] == "GET"


def test_settings_of_the_environment_are_read_and_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONSPLICE_PORT", "8123")
    assert Settings().port == 8123
    monkeypatch.setenv("MOTIONSPLICE_PORT", "soon")
    with pytest.raises(SettingsError, match="MOTIONSPLICE_PORT is 'soon'"):
        Settings()


def test_the_documentation_needs_no_other_host(client: TestClient) -> None:
    page = client.get("/", follow_redirects=True)
    assert page.url.path == "/docs"
    sources = re.findall(r"""(?:src|href)=["']([^"']+)""", page.text)
    assert sources
    for source in sources:
        assert source.startswith("/")
        assert client.get(source).status_code == 200


def test_the_schema_names_every_route_and_its_problems(client: TestClient) -> None:
    document = client.get("/openapi.json").json()
    assert set(document["paths"]) == {
        "/v1/bank", "/v1/clips", "/v1/clips/{name}", "/v1/pose", "/v1/splice", "/healthz", "/readyz",
    }  # fmt: skip
    pose = document["paths"]["/v1/pose"]["get"]
    assert {parameter["name"] for parameter in pose["parameters"]} >= {"locomotion", "time", "action", "posture"}
    assert {"404", "422", "503"} <= set(pose["responses"])
    for status in ("404", "422", "503"):
        assert "application/problem+json" in pose["responses"][status]["content"]
    assert set(document["components"]["schemas"]) == {"Pose", "ClipInfo", "BankInfo", "Problem"}
    OpenAPI.model_validate(document)
    for operations in document["paths"].values():
        assert operations["get"]["summary"]
        assert operations["get"]["description"]


def test_what_the_interactive_page_fills_in_can_be_answered(client: TestClient) -> None:
    for path, operations in client.get("/openapi.json").json()["paths"].items():
        filled = {one["name"]: one["example"] for one in operations["get"].get("parameters", []) if "example" in one}
        assert client.get(path.format_map(filled), params=filled if "{" not in path else {}).is_success


@pytest.fixture
def address(bank: Bank) -> Iterator[str]:
    """A service on a free port of this machine."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        server = uvicorn.Server(uvicorn.Config(create_app(bank), log_level="error"))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
        thread.start()
        url = f"http://127.0.0.1:{listener.getsockname()[1]}"
        for _ in range(600):
            try:
                urllib.request.urlopen(f"{url}/readyz", timeout=1.0).close()
                break
            except OSError:
                time.sleep(0.05)
        yield url
        server.should_exit = True
        thread.join(10.0)


def test_the_client_in_the_protocol_page_works(address: str, capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", PROTOCOL.read_text(), re.DOTALL)
    exec(example.replace("http://127.0.0.1:8000", address).replace("curve", "run"), {})
    assert "22 joints" in capsys.readouterr().out


@pytest.mark.parametrize("pace", ["fast", "realtime"])
def test_a_client_that_goes_away_ends_its_stream(address: str, monkeypatch: pytest.MonkeyPatch, pace: str) -> None:
    ended = threading.Event()

    async def endless(*args: Any) -> AsyncIterator[bytes]:
        try:
            while True:
                async for chunk in messages(*args):
                    yield chunk
        finally:
            ended.set()

    monkeypatch.setattr(routes, "messages", endless)
    answer = urllib.request.urlopen(f"{address}/v1/splice?locomotion=walk&pace={pace}", timeout=5.0)
    assert len(answer.read(100)) == 100
    assert not ended.is_set()
    answer.close()
    assert ended.wait(30.0)
