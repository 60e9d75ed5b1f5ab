"""The commands `look` and `aim` over a WebSocket and in a take."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from motionsplice.motion import quaternion
from motionsplice.motion.axes import AXES, Axes
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.aim import Aim, Look
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from tests.service.characters.player import Player
from tests.service.running import Running

WALK = {"do": "create", "locomotion": "walk"}
POINT, DIRECTION = (1.0, 1.5, 4.0), (-1.0, 0.2, 2.0)
LOOK: dict[str, Any] = {"do": "look", "blend": 0.1, "spine": 0.2, "steady": 0.5, "max_yaw": 1.0, "max_pitch": 0.5}
AIM: dict[str, Any] = {"do": "aim", "part": "right_arm", "weight": 0.9}


def expected(bank: Bank, frames: int, end: int) -> Any:
    """Returns the rotations [F, J, 4] of a character that looks and aims, until `end`, and then fades out."""
    characters, shown = Characters(Stage(Evaluator(bank)), 60.0), []
    characters.add(1, "walk")
    characters.look([0], Look(POINT, spine=0.2, steady=0.5, max_yaw=1.0, max_pitch=0.5), blend=0.1)
    characters.aim([0], Aim(direction=DIRECTION, part="right_arm", weight=0.9))
    for frame in range(frames):
        if frame == end:
            characters.look([0], None, blend=0.2)
            characters.aim([0], None)
        poses = characters.stage.evaluator.poses(1)
        characters.evaluate(poses)
        shown.append(poses.rotations[0].copy())
        characters.advance()
    return np.array(shown)


@pytest.mark.parametrize("axes", AXES.values(), ids=AXES.keys())
def test_a_take_looks_and_aims_in_the_axes_of_the_request(client: TestClient, bank: Bank, axes: Axes) -> None:
    point, direction = (axes.positions(np.array(to)).tolist() for to in (POINT, DIRECTION))
    commands = [
        *(WALK, {**LOOK, "point": point}, {**AIM, "direction": direction}),
        *({"at": 40, "do": "look", "direction": None, "blend": 0.2}, {"at": 40, "do": "aim", "point": None}),
    ]
    order = {"rate": 60, "frames": 100, "commands": commands}
    answer = client.post(f"/v1/take?axes={axes.name}&encoding=float32&format=json", json=order)
    assert answer.is_success, answer.text
    ours = np.empty((100, bank.skeleton.joint_count, 4))
    theirs = np.array(answer.json()["rotations"])
    ours[..., axes.order] = theirs[..., :3] * axes.turns
    ours[..., 3] = theirs[..., 3]
    assert quaternion.angle(ours, expected(bank, 100, 40)).max() < 1e-5


def test_a_websocket_looks_and_aims_and_ends_it(service: Running, bank: Bank) -> None:
    with Player(service) as player:
        here = {"id": 7}
        commands = {**WALK, **here}, {**LOOK, **here, "point": POINT}, {**AIM, **here, "direction": DIRECTION}
        first = player.do(*commands)["frame"]
        frames = player.frames_until(first + 40)
        end = player.do({"do": "look", "id": 7, "point": None, "blend": 0.2}, {"do": "aim", "id": 7, "point": None})
        frames += player.frames_until(end["frame"] + 60)
    shown = expected(bank, end["frame"] - first + 61, end["frame"] - first)
    compared = 0
    for frame in frames:
        if first <= frame["frame"] <= end["frame"] + 60:
            np.testing.assert_array_equal(frame["rotations"][0, 0], shown[frame["frame"] - first])
            compared += 1
    assert compared > 50


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ({"do": "look"}, "look requires a point or a direction, and not both. Give one of them; null ends it"),
        ({"do": "look", "point": [0, 0, 1], "direction": None}, "and not both"),
        ({"do": "look", "point": [0, 0]}, "point: expected a list of three numbers of at most 1,000,000,000, or null"),
        ({"do": "look", "point": [0, 0, 1e10]}, "point: expected"),
        ({"do": "look", "direction": [0, 0, 0]}, "direction: expected a list of three numbers that are not all 0"),
        ({"do": "look", "direction": [0, None, 1]}, "direction: expected"),
        (
            {"do": "place", "position": [1e30, 0, 0]},
            "position: expected a list of three numbers of at most 1,000,000,0",
        ),
        ({"do": "look", "point": None, "weight": 1}, "look: null ends it, and may have no other key than blend"),
        ({"do": "look", "point": [0, 0, 1], "part": "chest"}, "look has no key 'part'"),
        ({"do": "look", "point": [0, 0, 1], "spine": 2}, "spine: expected a number from 0 to 1, found 2"),
        ({"do": "aim", "point": [0, 0, 1], "part": "leg"}, "part: expected one of chest, left_arm, right_arm"),
        ({"do": "aim", "point": [0, 0, 1], "max_yaw": 3.2}, "max_yaw: expected radians from 0 to 2.62, found 3.2"),
        ({"do": "aim", "point": [0, 0, 1], "max_pitch": -1}, "max_pitch: expected radians from 0 to 1.40"),
    ],
)
def test_a_wrong_target_is_refused(client: TestClient, command: dict[str, Any], words: str) -> None:
    answer = client.post("/v1/take", json={"frames": 2, "commands": [WALK, command]})
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:motionsplice:request"), answer.text
    assert words in answer.json()["detail"]


def test_a_direction_may_have_any_length(client: TestClient) -> None:
    frames = []
    for length in (1e200, 1.0):
        look = {"do": "look", "direction": [length, 0, 0]}
        answer = client.post("/v1/take", json={"frames": 2, "commands": [WALK, look]}, params={"format": "json"})
        frames.append(answer.json()["rotations"])
    assert frames[0] == frames[1]
