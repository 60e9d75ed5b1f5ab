"""Checks docs/protocol.md against the service: its programs, its examples, and that it names everything."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from websockets.sync.client import connect
from websockets.typing import Origin

from motionsplice.motion.axes import AXES, Axes
from motionsplice.runtime.characters.state import EVENT_NAMES
from motionsplice.service.answers.batch import COLUMNS
from motionsplice.service.characters.commands import KEYS, NEEDED
from motionsplice.service.characters.hub import CHARACTERS
from motionsplice.service.exchange.job import JobInfo
from motionsplice.service.problems import PROBLEMS
from motionsplice.service.report import QualityReport
from motionsplice.service.serving import Edition
from motionsplice.service.wire.messages import PROTOCOL
from tests.service.characters.player import Player
from tests.service.running import Running

PAGE = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text()


EXAMPLES = [json.loads(block) for block in re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL)]
COMMANDS = [json.loads(command) for command in re.findall(r"^\| `({\"do\":.*?})` \|", PAGE, re.MULTILINE)]
EVENTS = {
    event["event"]: event
    for event in (
        *(example for example in EXAMPLES if "event" in example and "urn:motionsplice:origin" not in example.values()),
        *map(json.loads, re.findall(r"`({\"event\":.*?})` \|$", PAGE, re.MULTILINE)),
    )
}


def test_its_clients_work(service: Running, capsys: pytest.CaptureFixture[str]) -> None:
    examples = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(examples) == 3
    for example in examples:
        exec(example.replace("127.0.0.1:8000", f"127.0.0.1:{service.port}").replace("curve", "run"), {})
    printed = capsys.readouterr().out
    assert "22 joints" in printed
    assert "frame 60 of 2 characters" in printed
    assert re.search(r"200 pictures; the root moved to -?\d\.\d\d 0\.\d\d \d\.\d\d", printed)


def test_its_batch_is_answered(hands_client: TestClient) -> None:
    (batch,) = (example for example in EXAMPLES if "locomotion" in example)
    batch = json.loads(json.dumps(batch).replace("directions", "counting"))
    with_hands, without, walk = hands_client.post("/v1/poses", json=batch).json()["rotations"]
    assert with_hands != without
    assert with_hands != walk
    assert without != walk


def test_its_take_is_played(client: TestClient) -> None:
    (order,) = (example for example in EXAMPLES if "commands" in example)
    (example,) = (example for example in EXAMPLES if "phases" in example)
    take = client.post("/v1/take", json=order).json()
    assert take.keys() == example.keys()
    assert [event["action"] for event in take["events"] if event["event"] == "action_began"] == ["wave"]
    assert {key for event in take["events"] for key in event} == {key for event in example["events"] for key in event}


def test_its_commands_are_done(hands_service: Running) -> None:
    assert {command["do"] for command in COMMANDS} == set(NEEDED)
    with Player(hands_service) as player:
        for command in COMMANDS:
            fitting = json.loads(json.dumps(command).replace("directions", "counting"))
            reply = player.do({**fitting, "ref": "a1"})
            assert reply["event"] == "done", reply
            assert reply.keys() == EVENTS["done"].keys()


def test_its_events_have_the_keys_of_the_services(service: Running) -> None:
    with Player(service) as player:
        assert player.welcome.keys() == EVENTS["welcome"].keys()
        assert player.welcome["roles"].keys() > EVENTS["welcome"]["roles"].keys()
        for entry in EVENTS["welcome"]["clips"].values():
            assert entry.keys() == player.welcome["clips"]["walk"].keys()
        refused = player.do({"do": "create", "id": 7, "locomotion": "wlak", "ref": "a1"})
        assert {**refused, "detail": ""} == {**EVENTS["refused"], "detail": ""}
        player.do({"do": "set", "events": list(EVENT_NAMES.values())})
        player.do({"do": "create", "id": 7, "locomotion": "run", "loop": False})
        player.do({"do": "act", "id": 7, "action": "wave", "when": "foot", "loop": False})
        for name in EVENT_NAMES.values():
            player.events = [event for event in player.events if event["event"] != "done"]
            assert _event(player, name).keys() == EVENTS[name].keys()
        newest = service.config.front.shared.serving
        loop = service.server.servers[0].get_loop()
        loop.call_soon_threadsafe(newest.exchange, Edition.warm(newest.bank))
        assert player.event("bank").keys() == EVENTS["bank"].keys()
    with Player(service, "?format=json") as player:
        player.do({"do": "create", "id": 7, "locomotion": "run"})
        assert player.frame().keys() == EVENTS["frames"].keys()


def _event(player: Player, name: str) -> dict[str, Any]:
    """Returns an event of this name, and keeps the others."""
    while not (found := [event for event in player.events if event["event"] == name]):
        player.take()
    return found[0]


def test_it_has_an_example_of_every_event() -> None:
    connection = {"welcome", "frames", "done", "refused", "bank", "bank_kept", "closing"}
    connection |= {"sending_ended", "undelivered"}
    assert EVENTS.keys() == connection | set(EVENT_NAMES.values())


def test_its_other_examples_have_the_keys_of_the_services(client: TestClient) -> None:
    (job,) = (example for example in EXAMPLES if "stage" in example)
    assert job.keys() == JobInfo(state="running").model_dump().keys()
    (problem,) = (example for example in EXAMPLES if "title" in example)
    answer = client.get("/v1/pose?locomotion=wlak&time=0").json()
    assert {**problem, "detail": "", "request_id": ""} == {**answer, "detail": "", "request_id": ""}
    (report,) = (example for example in EXAMPLES if "targets" in example)
    assert QualityReport.model_validate(report).model_dump(mode="json") == report
    (feet,) = (example for example in EXAMPLES if "left" in example)
    assert feet.keys() == client.get("/v1/clips/walk").json()["contacts"].keys()


def test_it_names_the_version_of_the_protocol() -> None:
    assert f"It describes protocol {PROTOCOL}:" in PAGE
    assert EVENTS["welcome"]["protocol"] == PROTOCOL


def test_it_names_every_parameter_column_and_command(service: Running) -> None:
    named = {one["name"] for path in ("pose", "splice", "stream") for one in parameters(service, path)}
    named |= set(CHARACTERS.parameters)
    for name in {*named, *KEYS, *COLUMNS}:
        assert f"`{name}`" in PAGE or f'"{name}"' in PAGE, name
    for command in NEEDED:
        assert f'{{"do": "{command}"' in PAGE, command


def parameters(service: Running, path: str) -> list[dict[str, str]]:
    return service.config.front.app.openapi()["paths"][f"/v1/{path}"]["get"]["parameters"]


@pytest.mark.parametrize("axes", AXES.values(), ids=AXES.keys())
def test_its_tables_of_axes_are_right(axes: Axes) -> None:
    names = dict(zip("xyz", range(3), strict=True))

    def terms(text: str) -> list[tuple[int, int]]:
        return [(-1 if term.startswith("-") else 1, names[term[-1]]) for term in text.split(", ") if term != "w"]

    rows = re.findall(rf"^\| `{axes.name}`[^|]*\|[^|]*\| (\w+) \| ([^|]*) \| ([^|]*) \|$", PAGE, re.MULTILINE)
    ((unit, position, quaternion),) = (row for row in rows if row[0] in ("metre", "centimetre"))
    assert unit == axes.unit
    assert terms(position) == list(zip(axes.signs, axes.order, strict=True))
    assert terms(quaternion) == list(zip(axes.turns, axes.order, strict=True))
    (row,) = re.findall(rf"^\| [^|]*`{axes.name}`[^|]* \| (\(.*?\)) \| [^|]* \| (-?h) \|$", PAGE, re.MULTILINE)
    h = 0.7
    facing = eval(
        row[0].replace("sin", "math.sin").replace("cos", "math.cos").replace(" h", "(h)"), {"math": math, "h": h}
    )
    ours = axes.turn * h
    np.testing.assert_allclose(
        facing, axes.positions(np.array([math.sin(ours), 0.0, math.cos(ours)])) / axes.scale, atol=1e-12
    )
    assert row[1] == ("h" if axes.turn == 1 else "-h")


def test_its_refusal_of_a_page_is_the_services(service: Running) -> None:
    (wanted,) = (example for example in EXAMPLES if "urn:motionsplice:origin" in example.values())
    url = f"ws://127.0.0.1:{service.port}/v1/characters"
    with connect(url, origin=Origin("https://game.example")) as socket:
        assert json.loads(socket.recv()) == wanted


def test_it_names_every_problem() -> None:
    for status, kind in set(PROBLEMS.values()):
        assert re.search(rf"\|[ \d,]*{status}[ \d,]*\|[^|]*`{kind}`", PAGE), (status, kind)


def test_it_names_every_operation(service: Running) -> None:
    for path in service.config.front.app.openapi()["paths"]:
        assert f"`GET {path}" in PAGE or f"`POST {path}" in PAGE or f"`GET {path}`" in PAGE, path
