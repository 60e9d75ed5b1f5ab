"""Hands over the wire are those of the evaluator and of characters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from fastapi.testclient import TestClient

from motionsplice.motion.formats.bvh import parse
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Memory
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage
from tests.playing import command
from tests.service.characters.player import Player
from tests.service.messages import arrays, unpacked
from tests.service.running import Running

BLOBS = {"locomotion": "<i4", "action": "<i4", "hands": "<i4", "time": "<f8"}


def test_clips_list_the_hands_that_can_be_laid_on_them(hands_client: TestClient, client: TestClient) -> None:
    hands = {clip["name"]: clip["hands"] for clip in hands_client.get("/v1/clips").json()}
    assert hands == {"counting": ["counting_hands", "other_hands"], "run": ["counting_hands"], "walk": [], "wave": []}
    assert client.get("/v1/clips/walk").json()["hands"] == []


@pytest.mark.parametrize(
    ("locomotion", "action", "hands", "method"),
    [
        ("walk", "counting", "counting_hands", "splice"),
        ("run", "counting", "other_hands", "naive"),
        ("run", None, "counting_hands", "splice"),
        ("run", "wave", "counting_hands", "none"),
    ],
)
def test_a_pose_has_the_hands_of_the_evaluator(
    hands_client: TestClient, hands_bank: Bank, locomotion: str, action: str | None, hands: str, method: Any
) -> None:
    query = f"locomotion={locomotion}&time=1.25&hands={hands}&method={method}" + (f"&action={action}" if action else "")
    evaluator = Evaluator(hands_bank)
    wanted = evaluator.pose(Splice(locomotion, action, method=method, hands=hands), 1.25)
    bare = evaluator.pose(Splice(locomotion, action, method=method), 1.25)
    for _ in range(2):  # the second answer is from a cached query
        packed = msgpack.unpackb(hands_client.get(f"/v1/pose?{query}&format=msgpack").content)
        found = arrays(packed, hands_bank.skeleton.joint_count)
        np.testing.assert_array_equal(found["rotations"], wanted.rotations[0])
        np.testing.assert_array_equal(found["root_positions"], wanted.root_positions[0])
    assert np.abs(wanted.rotations - bare.rotations).max() > 0.1


def test_queries_that_differ_only_in_hands_have_different_answers(hands_client: TestClient) -> None:
    query = "/v1/pose?locomotion=run&action=counting&time=1.25"
    answers = [
        hands_client.get(query + hands).json() for hands in ("", "&hands=counting_hands", "&hands=other_hands", "")
    ]
    assert answers[0] == answers[3]
    assert len({str(one["rotations"]) for one in answers}) == 3


@pytest.mark.parametrize("form", ["json", "msgpack"])
def test_each_character_of_a_batch_has_its_own_hands(hands_client: TestClient, hands_bank: Bank, form: str) -> None:
    batch: dict[str, Any] = {
        "clips": ["walk", "counting", "run", "other_hands", "counting_hands"],
        "locomotion": [0, 0, 2, 2, 2],
        "action": [1, 1, -1, 1, -1],
        "hands": [3, 4, 4, -1, -1],
        "time": [0.5, 0.75, 1.0, 1.25, 1.5],
    }
    if form == "json":
        body = hands_client.post("/v1/poses", json=batch).json()
    else:
        packed = {key: np.array(one, BLOBS[key]).tobytes() if key in BLOBS else one for key, one in batch.items()}
        headers = {"content-type": "application/msgpack"}
        answer = hands_client.post("/v1/poses?format=msgpack", content=msgpack.packb(packed), headers=headers)
        body = arrays(msgpack.unpackb(answer.content), hands_bank.skeleton.joint_count, 5)
    evaluator, names = Evaluator(hands_bank), batch["clips"]
    for number in range(5):
        locomotion, action, hands = (batch[key][number] for key in ("locomotion", "action", "hands"))
        wanted = evaluator.pose(
            Splice(
                names[locomotion], names[action] if action >= 0 else None, hands=names[hands] if hands >= 0 else None
            ),
            batch["time"][number],
        )
        np.testing.assert_allclose(body["rotations"][number], wanted.rotations[0], atol=1e-7)


def test_splice_and_stream_have_the_hands_of_the_evaluator(hands_client: TestClient, hands_bank: Bank) -> None:
    query = "locomotion=run&action=counting&hands=counting_hands"
    evaluator, joints = Evaluator(hands_bank), hands_bank.skeleton.joint_count
    memory = Memory.begin(1, hands_bank.clip("run").rate)
    times = evaluator.frame_times("run")
    wanted = evaluator.sequence(Splice("run", "counting", hands="counting_hands"), times, memory=memory).rotations
    packed = msgpack.unpackb(hands_client.get(f"/v1/splice?{query}&format=msgpack").content)
    np.testing.assert_array_equal(arrays(packed, joints, len(times))["rotations"], wanted)
    header, *frames = unpacked(hands_client.get(f"/v1/stream?{query}&ahead=9").content)
    assert (header["action"], header["hands"]) == ("counting", "counting_hands")
    assert b"".join(frame["rotations"] for frame in frames) == packed["rotations"]
    file = hands_client.get(f"/v1/splice?{query}&format=bvh")
    assert 'filename="run+counting+counting_hands.bvh"' in file.headers["content-disposition"]
    read = parse(file.content)[0].rotations
    np.testing.assert_allclose(np.abs(np.sum(read * wanted, axis=-1)), 1.0, atol=1e-6)


def test_the_header_of_a_stream_without_hands_has_none(hands_client: TestClient) -> None:
    header = unpacked(hands_client.get("/v1/stream?locomotion=run&count=1").content)[0]
    assert header["hands"] is None


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("locomotion=walk&action=counting&hands=conting_hands", "no hands 'conting_hands'. Did you mean 'counting_"),
        ("locomotion=walk&action=counting&hands=wave", "the bank has no hands 'wave'"),
        ("locomotion=counting_hands", "the bank has no clip 'counting_hands'"),
        (
            "locomotion=run&action=wave&hands=counting_hands",
            "'counting_hands' are not aligned to clip 'wave'. They are aligned to 'counting', 'run'",
        ),
        ("locomotion=walk&hands=other_hands", "not aligned to clip 'walk'. They are aligned to 'counting'"),
    ],
)
@pytest.mark.parametrize("path", ["pose", "splice", "stream"])
def test_hands_that_cannot_be_laid_are_a_problem_that_lists_those_that_can(
    hands_client: TestClient, path: str, query: str, words: str
) -> None:
    answer = hands_client.get(f"/v1/{path}?{query}" + ("&time=0" if path == "pose" else ""))
    body = answer.json()
    assert (answer.status_code, body["type"]) == (404, "urn:motionsplice:unknown-clip")
    assert words in body["detail"]


def test_a_bank_without_hands_says_how_to_get_some(client: TestClient) -> None:
    answer = client.get("/v1/pose?locomotion=walk&time=0&hands=counting_hands")
    assert answer.status_code == 404
    assert "motionsplice precompute --hands BODY:HANDS" in answer.json()["detail"]


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [
        ({"hands": [-1, 3]}, 422, "character 1: hands 'counting_hands' are not aligned to clip 'walk'"),
        ({"hands": [0, 4]}, 422, "hands: character 1 has index 4, but there are 4 clips"),
        ({"hands": [0, -2]}, 422, "hands: character 1 has index -2"),
        ({"hands": [3]}, 422, "hands: expected 2 numbers, as many as locomotion has, found 1"),
        ({"hands": [3, 1.5]}, 422, "hands: expected a list of whole numbers"),
        ({"hands": [1, -1]}, 422, "hands: 'counting' is also used as a clip"),
        ({"clips": ["walk", "counting", "run", "cunting_hands"]}, 404, "Did you mean 'counting_hands'"),
        ({"action": [3, -1], "hands": [-1, -1]}, 404, "the bank has no clip 'counting_hands'"),
    ],
)
def test_a_batch_with_wrong_hands_is_refused(
    hands_client: TestClient, change: dict[str, Any], status: int, words: str
) -> None:
    batch = {"clips": ["walk", "counting", "run", "counting_hands"], "locomotion": [0, 0], "action": [1, -1]}
    answer = hands_client.post("/v1/poses", json=batch | {"time": [0.0, 0.5], "hands": [3, -1]} | change)
    assert (answer.status_code, words in answer.json()["detail"]) == (status, True), answer.text


def test_hands_that_no_character_uses_may_be_listed(hands_client: TestClient) -> None:
    batch = {"clips": ["walk", "counting_hands", "counting"], "locomotion": [0, 2], "time": [0.0, 0.5]}
    with_hands, without = (
        hands_client.post("/v1/poses", json=batch | {"hands": hands}) for hands in ([-1, 1], [-1, -1])
    )
    assert (with_hands.status_code, without.status_code) == (200, 200), without.text
    answer = hands_client.post("/v1/poses", json=batch | {"clips": ["walk", "none of both", "counting"]})
    assert (answer.status_code, "no clip 'none of both'" in answer.json()["detail"]) == (404, True)


def commanded(bank: Bank, commands: dict[int, list[tuple[str, dict[str, Any]]]], frames: int) -> list[Any]:
    """Returns rotations [J, 4] of a character in each frame; `commands` are done at some frames."""
    characters, frames_shown = Characters(Stage(Evaluator(bank)), 60.0), []
    for frame in range(frames):
        for do, values in commands.get(frame, []):
            command(characters, do, values)
        poses = characters.stage.evaluator.poses(1)
        characters.evaluate(poses)
        characters.advance()
        frames_shown.append(poses.rotations[0])
    return frames_shown


def test_hands_are_set_and_removed_over_a_websocket(hands_service: Running, hands_bank: Bank) -> None:
    act = {"action": "counting", "start": 1.5, "blend": 0.0}  # in the middle of a gesture
    wears: list[dict[str, Any]] = [
        {"hands": "counting_hands", "blend": 0.1, "curve": "linear"},
        {"hands": "other_hands", "blend": 0.2, "weight": 0.75},
        {"hands": None, "blend": 0.1},
    ]
    commands: dict[int, list[tuple[str, dict[str, Any]]]] = {0: [("add", {"locomotion": "walk"}), ("act", act)]}
    with Player(hands_service) as player:
        create = {"do": "create", "id": 7, "locomotion": "walk"}
        first = player.do(create, {"do": "act", "id": 7, **act})["frame"]
        frames = player.frames_until(first)
        for wear in wears:
            at = player.do({"do": "wear", "id": 7, **wear})["frame"]
            commands[at - first] = [("wear", wear)]
            frames += player.frames_until(at + 14)
    _, on, _, off = commands
    plain, shown = (commanded(hands_bank, some, off + 15) for some in ({0: commands[0]}, commands))
    for frame in frames:
        if (number := frame["frame"] - first) < len(shown):
            np.testing.assert_array_equal(frame["rotations"][0, 0], shown[number])
    differs = [bool(np.any(one != other)) for one, other in zip(plain, shown, strict=True)]
    assert any(differs[on:off])
    assert not any(differs[:on] + differs[off + 7 :])


def test_a_wrong_wear_command_is_refused_and_changes_nothing(hands_service: Running) -> None:
    with Player(hands_service) as player:
        player.do({"do": "create", "id": 7, "locomotion": "run"}, {"do": "speed", "id": 7, "speed": 0})
        before = player.frame()["rotations"]
        for wear, kind, words in (
            ({"hands": "conting_hands"}, "unknown-clip", "Did you mean 'counting_hands'"),
            ({"hands": "wave"}, "unknown-clip", "no hands 'wave'"),
            ({}, "request", "hands: missing, but wear requires it"),
            ({"hands": 3}, "request", "hands: expected the name of a hands clip, or null for none, found 3"),
            ({"hands": "counting_hands", "weight": 2}, "request", "weight: expected a number from 0 to 1, found 2"),
            (
                {"hands": "counting_hands", "mask": "arms"},
                "request",
                "wear has no key 'mask'. Its keys are hands, blend",
            ),
        ):
            reply = player.do({"do": "wear", "id": 7, **wear})
            assert (reply["event"], reply["type"]) == ("refused", f"urn:motionsplice:{kind}")
            assert words in reply["detail"]
        player.frames.clear()
        np.testing.assert_array_equal(player.frame()["rotations"], before)


@pytest.mark.parametrize("an_ordinary_clip", [False, True])
def test_a_connection_keeps_its_bank_while_a_newer_one_does_not_have_its_hands(
    hands_service: Running, bank: Bank, an_ordinary_clip: bool
) -> None:
    """Also if the hands are an ordinary clip now, as without `hands.toml`."""
    if an_ordinary_clip:
        clips = tuple(replace(one, name="other_hands") if one.name == "wave" else one for one in bank.clips)
        bank = replace(bank, manifest=replace(bank.manifest, clips=clips))
    serving = hands_service.config.front.shared.serving
    old, evaluator = serving.edition, Evaluator(bank)
    newer = type(old)(bank, evaluator, Stage(evaluator))
    loop = hands_service.server.servers[0].get_loop()
    try:
        with Player(hands_service) as player:
            player.do({"do": "create", "id": 7, "locomotion": "walk"}, {"do": "wear", "id": 7, "hands": "other_hands"})
            loop.call_soon_threadsafe(serving.exchange, newer)
            event = player.event("bank_kept")
            assert (event["bank"], event["missing"]) == (bank.digest, ["other_hands"])
            player.do({"do": "wear", "id": 7, "hands": None, "blend": 0})
            assert player.event("bank")["bank"] == bank.digest
    finally:
        loop.call_soon_threadsafe(serving.exchange, old)


def test_a_vrm_animation_has_the_fingers_of_the_hands(
    hands_client: TestClient, hands_bank: Bank, tmp_path: Path
) -> None:
    query = "locomotion=run&action=counting&hands=counting_hands"
    (tmp_path / "x.vrma").write_bytes(hands_client.get(f"/v1/splice?{query}&format=vrma").content)
    clip = read_clip(tmp_path / "x.vrma").clip
    wanted = Evaluator(hands_bank).clip(Splice("run", "counting", hands="counting_hands"))
    joints = [hands_bank.skeleton.index(name) for name in clip.skeleton.names]
    assert len(joints) == hands_bank.skeleton.joint_count == 52
    np.testing.assert_allclose(joint_positions(clip), joint_positions(wanted)[:, joints], atol=1e-5)
