"""The add-on for Blender (clients/blender): its WebSocket on a live service, and its bones where `bpy` is installed."""

from __future__ import annotations

import json
import os
import runpy
import subprocess
import sys
from http.server import BaseHTTPRequestHandler, HTTPServer
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import pytest
from pydantic import SecretStr

from motionsplice.runtime.bank import Bank
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from tests.clients.happenings import lose, newer_bank
from tests.service.running import Running, eventually, running

ROOT = Path(__file__).parents[2]
CLIENT = ROOT / "clients" / "blender"
PYTHON = os.environ.get("BPY_PYTHON") or (sys.executable if find_spec("bpy") else "")
MINUTES = 300.0  # seconds, far more than the script takes


@pytest.fixture
def addon(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The add-on's names, without Blender."""
    bpy: Any = ModuleType("bpy")
    bpy.types, bpy.props = MagicMock(PropertyGroup=object, Operator=object, Panel=object), MagicMock()
    bpy.context, bpy.data, bpy.ops = MagicMock(), MagicMock(), MagicMock()
    monkeypatch.setitem(sys.modules, "bpy", bpy)
    monkeypatch.setitem(sys.modules, "mathutils", MagicMock())
    return runpy.run_path(str(CLIENT / "motionsplice.py"))


def test_its_websocket_receives_what_the_service_sends(addon: dict[str, Any], service: Running) -> None:
    link = addon["Link"](service.url, "/v1/characters?format=json&axes=blender")
    events = iter(link)
    assert next(events)["event"] == "welcome"
    link.send({"do": "create", "id": 0, "locomotion": "walk"})
    assert next(events)["event"] == "done"
    assert next(events)["ids"] == [0]
    link.send({"do": "create", "id": list(range(1, 80)), "locomotion": "run"})  # a long message, longer answers
    frame = next(event for event in events if len(event.get("ids", ())) == 80)
    assert len(json.dumps(frame)) > 65_536
    service.server.servers[0].get_loop().call_soon_threadsafe(lose, service.config.front)
    assert {event["event"] for event in events} <= {"frames"}  # and it ends
    link.close()


def test_its_websocket_says_why_the_service_refuses(addon: dict[str, Any], service: Running) -> None:
    with pytest.raises(addon["ServiceError"], match="'rat'"):
        addon["Link"](service.url, "/v1/characters?rat=60")
    with pytest.raises(addon["ServiceError"], match="motionsplice serve BANK"):
        addon["Link"]("http://127.0.0.1:1", "/v1/characters")


def test_an_address_may_lack_its_scheme_and_end_with_a_slash(addon: dict[str, Any], service: Running) -> None:
    for address in (service.url.removeprefix("http://"), service.url + "/"):
        connection, answer = addon["request"](address, "/v1/skeleton", "")
        assert "joints" in json.loads(answer.read())
        connection.close()


@pytest.mark.parametrize("status", [200, 404])
def test_another_server_is_not_taken_for_the_service(addon: dict[str, Any], status: int) -> None:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(status)
            self.end_headers()
            self.wfile.write(b"<html>")

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        with pytest.raises(addon["ServiceError"], match=f"not a motionsplice service: it answered {status}"):
            addon["Link"](f"http://127.0.0.1:{server.server_port}", "/v1/characters")
        server.shutdown()


def test_a_wrong_token_is_reported_in_the_add_ons_terms(addon: dict[str, Any], bank: Bank) -> None:
    with running(bank.path, Settings(token=SecretStr("right-token"))) as guarded:
        for token in ("", "wrong-token"):
            with pytest.raises(addon["ServiceError"], match="Enter the token of the service"):
                addon["Link"](guarded.url, "/v1/characters", token)
        link = addon["Link"](guarded.url, "/v1/characters", "right-token")
        assert next(events := iter(link))["event"] == "welcome"
        link.close()
        assert not list(events)


@pytest.fixture
def armature() -> MagicMock:
    armature = MagicMock(session_uid=7)
    armature.data.bones = ["Hips"]
    sys.modules["bpy"].data.objects = [armature]
    return armature


def test_a_preview_ends_when_its_armature_is_not_in_the_file(
    addon: dict[str, Any], service: Running, armature: MagicMock
) -> None:
    preview = addon["Preview"](armature, service.url, "")
    eventually(lambda: preview.tick() == addon["TICK"] and preview.rig is not None)
    armature.session_uid = 8  # the armature of this name in another file
    assert preview.tick() is None
    assert addon["Preview"].running is None
    assert addon["Preview"].status.startswith("the armature was deleted")
    eventually(lambda: preview.link.socket.fileno() == -1)
    with pytest.raises(addon["ServiceError"], match="Press Preview again"):
        preview.play("walk", "wave")


def test_a_preview_ends_when_the_service_stops(addon: dict[str, Any], bank: Bank, armature: MagicMock) -> None:
    with running(bank.path, Settings()) as stopping:
        preview = addon["Preview"](armature, stopping.url, "")
        eventually(lambda: preview.tick() == addon["TICK"] and preview.rig is not None)
    eventually(lambda: preview.tick() is None)
    assert addon["Preview"].status == "the connection was lost. Press Preview to connect again"


def test_a_preview_needs_an_armature_with_joints_of_the_bank(
    addon: dict[str, Any], service: Running, armature: MagicMock
) -> None:
    armature.data.bones = ["Bone"]
    preview = addon["Preview"](armature, service.url, "")
    eventually(lambda: preview.tick() is None)
    assert addon["Preview"].status == "the armature has none of the bank's joints, such as 'Hips'"


@pytest.mark.parametrize("error", [RuntimeError("Traceback ..."), AttributeError("could not be found")])
def test_a_failing_importer_is_reported_without_traceback(
    addon: dict[str, Any], service: Running, error: Exception
) -> None:
    sys.modules["bpy"].ops.import_scene.gltf.side_effect = error
    settings = SimpleNamespace(address=service.url, token="", locomotion="walk", action="wave")
    operator = addon["ImportSplice"]()
    operator.report = MagicMock()
    assert operator.execute(SimpleNamespace(scene=SimpleNamespace(motionsplice=settings))) == {"CANCELLED"}
    assert "Blender's importer failed" in operator.report.call_args.args[1]


@pytest.mark.skipif(not PYTHON, reason="bpy is not installed: set BPY_PYTHON to a Python that has it")
def test_bones_are_where_the_service_has_them(service: Running, clip_folder: Path, tmp_path: Path) -> None:
    newer = Edition.warm(newer_bank(clip_folder, tmp_path))
    loop = service.server.servers[0].get_loop()
    command = [PYTHON, str(CLIENT / "tests" / "positions.py"), str(ROOT / "tests/golden/files"), service.url]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        lines = []
        for line in process.stdout:
            lines.append(line)
            if line == "exchange\n":
                loop.call_soon_threadsafe(service.config.front.shared.serving.exchange, newer)
        assert process.wait(MINUTES) == 0, lines
    found = json.loads(lines[-1])
    print(found)
    assert found["golden"].keys() == {f"{a} {b}" for a in ("float32", "int16") for b in ("plain", "turned")}
    for name, worst in found["golden"].items():
        assert worst < (1e-5 if name.startswith("float32") else 3e-4)  # of which int16 is nearly all
    assert found["frames"] == 1000
    assert max(found["splice"], found["live"]) < 1e-5
    assert len(found["refused"]) == 2
    assert all("no clip 'wlak'" in detail for detail in found["refused"])
