"""The add-on for Godot (clients/godot): Godot 3 on golden files and a live service, and the syntax of Godot 4."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.service.serving import Edition
from tests.clients.godot import CLIENT, GODOT, MINUTES, project, script
from tests.clients.happenings import lose
from tests.service.running import Running

ROOT = Path(__file__).parents[2]
WINDOW = 10.0  # seconds, for which playback keeps samples of the clocks' offset
GDPARSE = shutil.which("gdparse")
needs_godot = pytest.mark.skipif(GODOT is None, reason="Godot 3 is not installed: apt-get install godot3-server")


@needs_godot
def test_bones_are_at_the_world_positions_of_the_golden_files(tmp_path: Path) -> None:
    with script(project(tmp_path), "golden.gd", GOLDEN=str(ROOT / "tests/golden/files")) as process:
        printed, _ = process.communicate(timeout=MINUTES)
    assert "ERROR" not in printed, printed
    results = [json.loads(line) for line in printed.splitlines() if line.startswith("{")]
    assert [(one["encoding"], one["kind"]) for one in results] == [
        (encoding, kind) for encoding in ("float32", "int16") for kind in ("plain", "turned")
    ]
    for one in results:
        assert (one["ids"], one["poses"]) == ([7, 4294967295], 4)
        assert one["worst"] < (1e-5 if one["encoding"] == "float32" else 3e-4)  # of which int16 is nearly all


@needs_godot
def test_bones_are_where_the_service_has_them_through_an_exchange_and_a_reconnection(
    service: Running, bank: Bank, other: Bank, tmp_path: Path
) -> None:
    front, loop = service.config.front, service.server.servers[0].get_loop()
    newer, url = Edition.warm(other), service.url.replace("http", "ws")
    with script(project(tmp_path), "live.gd", URL=url) as process:
        assert process.stdout is not None
        printed = []
        for line in process.stdout:
            printed.append(line)
            if '"stage":2' in line:
                loop.call_soon_threadsafe(front.shared.serving.exchange, newer)
            elif '"stage":3' in line:
                loop.call_soon_threadsafe(lose, front)
        assert process.wait(MINUTES) == 0, printed
    assert not [line for line in printed if "SCRIPT ERROR" in line], printed
    results = next(json.loads(line) for line in printed if line.startswith("[{"))
    assert len(results) == 4
    for one in results:
        print({key: value for key, value in one.items() if key != "log"})
        assert sum(one["counts"]) >= 1000
        assert one["worst"] < (1e-5 if one["encoding"] == "float32" else 3e-4)
        assert one["banks"] == [bank.digest, other.digest, other.digest]
        assert one["events"] == {"welcome": 2, "bank": 1, "done": 5, "refused": 2, "action_began": 2}
        assert (one["jumps"], one["parts_of_jumps"]) == (3, 0)
    check_playback(next(one["log"] for one in results if (one["encoding"], one["ahead"]) == ("float32", 1)))


def check_playback(log: list[dict[str, Any]]) -> None:
    """Checks what was shown between frames against the program of docs/protocol.md."""
    page = (ROOT / "docs" / "protocol.md").read_text()
    program = next(block for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "class Playback" in block)
    names: dict[str, Any] = {}
    exec(program[: program.index("with connect(")], names)
    playback, pictures, between = names["Playback"](60), 0, 0
    for entry in log:
        if entry["now"] - log[0]["now"] > WINDOW:
            break  # on a busy machine: the program forgets old samples at pictures, and the client at messages
        if "message" in entry:
            playback.take(first_alone(base64.b64decode(entry["message"])), entry["now"])
            continue
        root, rotations = playback.at(entry["now"], entry["passed"])
        assert playback.delay == pytest.approx(entry["delay"], abs=1e-6)
        assert root == pytest.approx(entry["root"], abs=1e-4)
        assert rotations[5] == pytest.approx(entry["turn"], abs=1e-4)
        pictures += 1
        between += root != playback.frames[0].root
    assert pictures > 100
    assert between > pictures / 2


def first_alone(message: bytes) -> bytes:
    """Returns a message of frames with character 1 alone, as the program expects."""
    fields = msgpack.unpackb(message)
    ids = np.frombuffer(fields["ids"], "<u4")
    (row,) = np.flatnonzero(ids == 1)
    for name in ("root_positions", "rotations"):
        numbers = np.frombuffer(fields[name], "<f4").reshape(fields["count"], len(ids), -1)
        fields[name] = numbers[:, row].tobytes()
    return msgpack.packb(fields)


@pytest.mark.skipif(GDPARSE is None, reason="gdtoolkit is not installed: pip install gdtoolkit")
@pytest.mark.parametrize(
    "file",
    sorted([*CLIENT.glob("shared/*.gd"), *CLIENT.glob("godot4/*.gd")]),
    ids=lambda file: f"{file.parent.name}-{file.stem}",
)
def test_the_syntax_is_godot_4s(file: Path) -> None:
    assert GDPARSE is not None
    subprocess.run([GDPARSE, str(file)], check=True, capture_output=True, timeout=MINUTES)
