"""The C# client (clients/csharp) on a live service: joints, commands, failures, its README's program, Unity.

The Unity components are compiled and run against the stand-in for UnityEngine in tests/clients/csharp, not in Unity.
"""

from __future__ import annotations

import json
import re
import subprocess
import urllib.request
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from websockets.sync.server import ServerConnection, serve

from motionsplice.runtime.bank import Bank
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from tests.clients.happenings import lose
from tests.clients.mono import GOLDEN, ROOT, SOURCES, compiled, needs_mono, printed, started
from tests.clients.processes import MINUTES
from tests.clients.samples import placed
from tests.service.running import Running, running

pytestmark = needs_mono


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The client, the Unity components and the tests' program."""
    return compiled(tmp_path_factory.mktemp("csharp") / "program.exe", SOURCES)


def test_joints_are_where_the_service_has_them_through_an_exchange_and_a_reconnection(
    program: Path, bank: Bank, other: Bank
) -> None:
    newer = Edition.warm(other)
    with running(bank.path, Settings()) as service, started(program, "live", service.url) as line:
        front, loop = service.config.front, service.server.servers[0].get_loop()
        assert line() == {"do": "", "ready": True}
        loop.call_soon_threadsafe(front.shared.serving.exchange, newer)
        assert line() == {"do": "", "exchanged": True}
        loop.call_soon_threadsafe(lose, front)
        results = line()["results"]
    assert [(one["encoding"], one["ahead"]) for one in results] == [
        (encoding, ahead) for encoding in ("float32", "int16") for ahead in (1, 8)
    ]
    for one in results:
        print({key: value for key, value in one.items() if key != "samples"})
        assert one["frames"] >= 1000
        assert one["banks"] == [bank.digest, other.digest]
        assert one["worst"] < (1e-5 if one["encoding"] == "float32" else 3e-4)  # of which int16 is nearly all
        assert one["characters"] == 3
        assert one["late"] >= 0  # a command that was given without a connection
        assert one["failures"] == ["the connection is lost: closed with code 1011 lost"]
        assert one["jump"] < 0.3  # metres, not 5.8 as to the origin; the stride has another phase
        assert one["held"] < 0.5  # the delay's
        assert len(one["samples"]) == 10
        for sample in one["samples"]:
            assert np.abs(placed(sample, one["encoding"]) - sample["positions"]).max() < 1e-5


def test_a_service_that_misbehaves_is_reported_and_left(program: Path) -> None:
    """A malformed message, then silence; another protocol on the next connection."""
    welcome = {**json.loads((GOLDEN / "rig.gltf.json").read_text()), "event": "welcome", "protocol": 3}
    protocols = iter((3, 4))

    def misbehave(socket: ServerConnection) -> None:
        socket.send(json.dumps({**welcome, "protocol": next(protocols)}))
        for text in socket:
            (command,) = json.loads(text)
            socket.send(json.dumps({"event": "done", "ref": command["ref"], "frame": 0}))
            socket.send(b"\x80")

    with serve(misbehave, "127.0.0.1", 0) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        (found,) = printed(program, "failures", f"http://127.0.0.1:{server.socket.getsockname()[1]}")
    assert found["failures"] == [
        "malformed frames: found no frame, rate or time. Are client and service of one version?",
        "the connection is lost: no message for a while",
        "expected protocol 3, found 4",
    ]


def test_every_command_is_done_and_refusals_say_why(program: Path, service: Running) -> None:
    found, *failed = printed(program, "commands", service.url)
    assert len(found["frames"]) == 11
    assert found["frames"] == sorted(found["frames"])
    assert found["removed"] > found["frames"][-1]
    assert "stride" in found["events"]
    assert [text.partition(" ")[0].removeprefix("urn:motionsplice:") for text in found["refused"]] == [
        "unknown-clip",
        "request",
        "request",
        "request",
        "unknown-clip",
    ]
    assert "Did you mean 'walk'" in found["refused"][0]
    assert repr('no "hands" \\ é') in found["refused"][4]
    assert found["heading"] == pytest.approx(-1.0, abs=0.3)  # placed there, and walking in centimetres since
    assert np.abs(np.subtract(found["ground"], [50.0, 60.0, 0.0])).max() < 100.0
    nobody, nothing = (one["error"] for one in failed)
    assert nobody.startswith("cannot connect to ")
    assert nothing == "no WebSocket here. Connect to /v1/characters."


def test_unity_bones_with_axes_of_their_own_are_where_the_joints_are(program: Path, service: Running) -> None:
    (found,) = printed(program, "unity", service.url, "none")
    assert not found["errors"]
    assert found["pictures"] == 300
    assert found["worst"] < 1e-5
    assert np.linalg.norm(np.subtract(found["end"], found["start"])) > 0.5  # metres: root motion moves the object
    joints = json.loads(urllib.request.urlopen(f"{service.url}/v1/skeleton").read())["joints"]
    (found,) = printed(program, "unity", service.url, joints[2])
    assert found["errors"] == [f"hero: no bones are named {joints[2]}. Build the bank on this character's skeleton."]


def test_the_readmes_program_runs(service: Running, tmp_path: Path) -> None:
    example, _ = re.findall(r"```csharp\n(.*?)```", (ROOT / "clients/csharp/README.md").read_text(), re.DOTALL)
    (tmp_path / "Walker.cs").write_text(example)
    client = ROOT / "clients" / "csharp" / "MotionSplice.cs"
    compiled(tmp_path / "Walker.exe", [tmp_path / "Walker.cs", client])
    command = ["mono", "Walker.exe", service.url]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=MINUTES)
    lines = done.stdout.splitlines()
    assert len(lines) > 60, done.stderr
    assert all(line.endswith(" 22 joints") for line in lines)
    assert len(set(lines)) > 60  # it moves
