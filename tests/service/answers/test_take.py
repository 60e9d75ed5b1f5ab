"""POST /v1/take: the frames that a WebSocket would send, at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from fastapi.testclient import TestClient

from motionsplice.motion.axes import AXES
from motionsplice.motion.formats.reading import read_clip
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage
from tests.playing import command
from tests.service.messages import blob_offsets

WALK = {"do": "create", "locomotion": "walk"}
WAVE = {"do": "act", "action": "wave"}


def take(client: TestClient, frames: int, *commands: dict[str, Any], query: str = "") -> dict[str, Any]:
    """Returns a take, with its arrays as NumPy's."""
    order = {"rate": 60, "frames": frames, "commands": commands}
    answer = client.post(f"/v1/take?format=msgpack{query}", json=order)
    assert answer.is_success, answer.text
    assert not any(offset % 4 for offset in blob_offsets(answer.content).values())
    found = msgpack.unpackb(answer.content)
    sizes = {"root_positions": (3,), "rotations": (-1, 4), "world_positions": (-1, 3), "phases": (), "action_times": ()}
    for name, shape in sizes.items():
        if name in found:
            found[name] = np.frombuffer(found[name], "<f4").reshape(frames, *shape)
    return found


def test_its_frames_are_those_of_a_character(client: TestClient, bank: Bank) -> None:
    later = {**WAVE, "at": 20, "when": "foot", "mask": "arms", "loop": False}
    stop = {"at": 70, "do": "speed", "speed": 0.5}
    found = take(client, 100, {**WALK, "position": [1, 0, 2], "heading": 0.5}, later, stop)
    characters = Characters(Stage(Evaluator(bank)), 60.0)
    command(characters, "add", {"locomotion": "walk"})
    command(characters, "place", {"position": (1, 0, 2), "heading": 0.5})
    poses, events = characters.stage.evaluator.poses(1), 0
    for frame in range(100):
        if frame == 20:
            command(characters, "act", {"action": "wave", "when": "foot", "mask": "arms", "loop": False})
        if frame == 70:
            command(characters, "speed", {"speed": 0.5})
        characters.evaluate(poses)
        np.testing.assert_array_equal(found["rotations"][frame], poses.rotations[0])
        np.testing.assert_array_equal(found["root_positions"][frame], poses.root_positions[0])
        events += int(characters.advance() > 0)
    (began,) = [one for one in found["events"] if one["event"] == "action_began"]
    assert began["action"] == "wave"
    assert began["frame"] > 20
    assert [np.isnan(found["action_times"][at]) for at in (began["frame"] - 1, began["frame"])] == [True, False]
    assert {"left_down", "right_down", "stride"} <= {one["event"] for one in found["events"]}


def test_it_plays_the_splice_from_the_origin_on(client: TestClient, bank: Bank) -> None:
    """All joints but the root turn as in the splice, and the moments are those of the alignment."""
    found = take(client, 200, {**WALK, "loop": False}, {**WAVE, "blend": 0})
    evaluator, times = Evaluator(bank), np.arange(200) / 60.0
    splice = Splice("walk", "wave")
    expected = evaluator.sequence(splice, times)
    np.testing.assert_allclose(found["rotations"][:, 1:], expected.rotations[:, 1:], atol=1e-5)
    rate = bank.clip("wave").rate
    np.testing.assert_allclose(found["action_times"], evaluator.action_frames(splice, times) / rate, atol=1e-3)
    steps = np.linalg.norm(np.diff(found["root_positions"], axis=0), axis=1)
    np.testing.assert_allclose(steps, np.linalg.norm(np.diff(expected.root_positions, axis=0), axis=1), atol=1e-4)
    strides = np.interp(times, np.arange(len(bank.phase("walk"))) / bank.clip("walk").rate, bank.phase("walk"))
    np.testing.assert_allclose(found["phases"], strides, atol=1e-4)


def test_without_an_action_there_is_no_time_of_it(client: TestClient) -> None:
    assert np.isnan(take(client, 3, WALK)["action_times"]).all()
    order = {"frames": 3, "commands": [WALK, {**WAVE, "at": 2}]}
    answer = client.post("/v1/take", json=order).json()
    assert answer["action_times"][:2] == [None, None]
    assert answer["action_times"][2] >= 0.0
    assert answer["rate"] == 60.0
    assert np.array(answer["rotations"]).shape[0] == 3


def test_an_action_that_was_stopped_has_no_time(client: TestClient) -> None:
    times = take(client, 60, WALK, WAVE, {"at": 20, "do": "stop", "blend": 0.1})["action_times"]
    assert np.isfinite(times[:20]).all()
    assert np.isnan(times[30:]).all()


@pytest.mark.parametrize("name", ["unity", "unreal", "blender"])
def test_commands_and_frames_are_in_the_axes_of_the_query(client: TestClient, name: str) -> None:
    axes, place = AXES[name], np.array([1.0, 0.0, 2.0])
    ours = take(client, 5, {**WALK, "position": place.tolist(), "heading": 0.5}, query="&parts=both")
    there = axes.positions(place).tolist()
    theirs = take(client, 5, {**WALK, "position": there, "heading": 0.5 * axes.turn}, query=f"&parts=both&axes={name}")
    for key in ("root_positions", "world_positions"):
        expected = axes.positions(ours[key].astype(np.float64))
        np.testing.assert_allclose(theirs[key], expected, atol=1e-5 * axes.scale)


@pytest.mark.parametrize("form", ["bvh", "glb", "gltf", "vrma"])
def test_it_is_written_as_a_file(client: TestClient, tmp_path: Path, form: str) -> None:
    order = {"rate": 30, "frames": 12, "commands": [WALK, WAVE]}
    answer = client.post(f"/v1/take?format={form}", json=order)
    assert answer.headers["content-disposition"] == f'attachment; filename="walk+wave.{form}"'
    path = tmp_path / f"take.{form}"
    path.write_bytes(answer.content)
    clip = read_clip(path).clip
    assert (clip.frame_count, round(clip.rate)) == (12, 30)


def test_a_mix_names_its_file(client: TestClient) -> None:
    mixed = {"do": "create", "locomotion": {"walk": 0.5, "run": 0.5}}
    answer = client.post("/v1/take?format=bvh", json={"frames": 2, "commands": [mixed]})
    assert answer.headers["content-disposition"] == 'attachment; filename="walk+run.bvh"'


@pytest.mark.parametrize(
    ("order", "status", "detail"),
    [
        ([], 422, "the body is not a map"),
        ({"frames": 3, "commands": [WALK], "fames": 3}, 422, "unknown key 'fames'. Did you mean 'frames'"),
        ({"commands": [WALK]}, 422, "frames: expected a whole number from 1, found None"),
        ({"frames": True, "commands": [WALK]}, 422, "frames: expected a whole number from 1, found True"),
        ({"frames": 5001, "commands": [WALK]}, 422, "frames: 5001 are more than 5000"),
        ({"frames": 3, "rate": 0, "commands": [WALK]}, 422, "rate: expected frames per second from 1 to 1000, found 0"),
        ({"frames": 3, "rate": "60", "commands": [WALK]}, 422, "rate: expected"),
        ({"frames": 3}, 422, "commands: expected a list of maps"),
        ({"frames": 3, "commands": [WALK, 3]}, 422, "commands: expected a list of maps"),
        ({"frames": 3, "commands": []}, 422, "commands: the list is empty. Begin with create"),
        ({"frames": 3, "commands": [WAVE]}, 422, "command 0: do: the first command, and no other, must be create"),
        ({"frames": 3, "commands": [WALK, WALK]}, 422, "command 1: do: the first command, and no other, must be"),
        ({"frames": 3, "commands": [{**WALK, "at": 1}]}, 422, "must be create, at frame 0"),
        (
            {"frames": 3, "commands": [WALK, {**WAVE, "at": 3}]},
            422,
            "command 1: at: expected a frame from 0 to 2, found 3",
        ),
        ({"frames": 3, "commands": [WALK, {**WAVE, "at": 1.5}]}, 422, "command 1: at: expected a frame from 0 to 2"),
        ({"frames": 3, "commands": [WALK, {"do": "remove"}]}, 422, "command 1: do: a take has no command 'remove'"),
        ({"frames": 3, "commands": [WALK, {"do": []}]}, 422, "command 1: do: a take has no command []"),
        ({"frames": 3, "commands": [{**WALK, "id": 1}]}, 422, "command 0: id: a take has one character. Leave it out"),
        (
            {"frames": 3, "commands": [WALK, {**WAVE, "weight": 2}]},
            422,
            "command 1: weight: expected a number from",
        ),
        ({"frames": 3, "commands": [WALK, {**WAVE, "action": "wvae"}]}, 404, "Did you mean 'wave'"),
        ({"frames": 3, "commands": [WALK, {**WAVE, "start": 99}]}, 422, "start 99 s"),
    ],
)
def test_it_refuses_what_it_cannot_play(client: TestClient, order: Any, status: int, detail: str) -> None:
    answer = client.post("/v1/take", json=order)
    assert answer.status_code == status
    assert detail in answer.json()["detail"]


def test_it_refuses_bodies_that_are_not_json(client: TestClient) -> None:
    json = {"content-type": "application/json"}
    assert client.post("/v1/take", content=b"{", headers=json).status_code == 422
    assert client.post("/v1/take", content=b"[" * 100_000, headers=json).status_code == 413
    assert client.post("/v1/take", content=b"[" * 60_000, headers=json).status_code == 422
    assert client.post("/v1/take", content=b"{}", headers={"content-type": "text/plain"}).status_code == 415
    assert client.post("/v1/take?format=bvh&axes=unity", json={"frames": 1, "commands": [WALK]}).status_code == 422
