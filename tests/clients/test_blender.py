"""The add-on for Blender (clients/blender): its WebSocket on a live service, and its bones where `bpy` is installed."""

from __future__ import annotations

import json
import os
import runpy
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import MagicMock

import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from tests.clients.happenings import lose, newer_bank
from tests.service.running import Running, running

ROOT = Path(__file__).parents[2]
CLIENT = ROOT / "clients" / "blender"
PYTHON = os.environ.get("BPY_PYTHON") or (sys.executable if find_spec("bpy") else "")
MINUTES = 300.0  # seconds, far more than the script takes


@pytest.fixture(scope="module")
def service(bank: Bank) -> Iterator[Running]:
    with running(bank.path, Settings()) as service:
        yield service


@pytest.fixture
def addon(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The add-on's names, without Blender."""
    bpy: Any = ModuleType("bpy")
    bpy.types, bpy.props = MagicMock(PropertyGroup=object, Operator=object, Panel=object), MagicMock()
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
