from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Posture
from motionsplice.runtime.stage import Stage
from motionsplice.service.settings import Settings
from tests.playing import command
from tests.service.characters.player import Player
from tests.service.running import Running, eventually, running

WALK = {"do": "create", "id": 7, "locomotion": "walk"}
FRAGMENTS = b"\x01\x80mask" + 1023 * b"\x00\x80mask"  # of a message that never ends


def twin(bank: Bank, *commands: tuple[str, dict[str, Any]], frames: int = 0) -> tuple[Any, Any]:
    """Returns the root position [3] and rotations [J, 4] of a character `frames` frames after its commands."""
    characters = Characters(Stage(Evaluator(bank)), 60.0)
    for do, values in commands:
        command(characters, do, values)
    for _ in range(frames):
        characters.evaluate(characters.stage.evaluator.poses(1))
        characters.advance()
    poses = characters.stage.evaluator.poses(1)
    characters.evaluate(poses)
    return poses.root_positions[0], poses.rotations[0]


def test_frames_are_those_of_the_runtime_and_numbered_by_the_connections_clock(service: Running, bank: Bank) -> None:
    with Player(service, "?rate=60") as player:
        assert player.welcome["bank"] == bank.digest
        assert player.welcome["protocol"] == 3
        assert (player.welcome["rate"], player.welcome["ahead"]) == (60.0, 1)
        act = {"do": "act", "id": 7, "action": "wave", "when": "foot", "mask": "arms"}
        first = player.do({**WALK, "position": [1, 0, 2], "heading": 0.5}, act)["frame"]
        frames = player.frames_until(first + 40)
        assert frames[0]["frame"] == first
        acted = "act", {"action": "wave", "when": "foot", "mask": "arms"}
        added = ("add", {"locomotion": "walk"}), ("place", {"position": (1, 0, 2), "heading": 0.5})
        for frame in frames[::10]:
            later = frame["frame"] - first
            root, rotations = twin(bank, *added, acted, frames=later)
            np.testing.assert_array_equal(frame["rotations"][0, 0], rotations)
            np.testing.assert_array_equal(frame["root_positions"][0, 0], root)
        due = np.array([frame["time"] for frame in frames])
        numbers = np.array([frame["frame"] for frame in frames])
        np.testing.assert_allclose(np.diff(due), np.diff(numbers) / 60.0, atol=1e-3)
        assert all(frame["ids"] == [7] and frame["count"] == 1 for frame in frames)


def test_feet_are_locked_from_the_beginning_or_by_a_command(service: Running, bank: Bank) -> None:
    with Player(service) as player:
        walks = {**WALK, "locomotion": {"walk": 1, "run": 1}, "lock_feet": True}
        first = player.do(walks, {**walks, "id": 8, "lock_feet": False})["frame"]
        frame = player.frames_until(first + 30)[-1]
        mix = {"locomotion": {"walk": 1, "run": 1}}
        for row, locks in enumerate((True, False)):
            lock = "lock_feet", {"lock_feet": locks}
            rotations = twin(bank, ("add", mix), lock, frames=frame["frame"] - first)[1]
            np.testing.assert_array_equal(frame["rotations"][0, row], rotations)
        assert (frame["rotations"][0, 0] != frame["rotations"][0, 1]).any()
        done = player.do({"do": "lock_feet", "id": 7, "lock_feet": False})["frame"]
        frame = player.frames_until(done + 14)[-1]
        np.testing.assert_array_equal(frame["rotations"][0, 0], frame["rotations"][0, 1])


def test_commands_change_what_they_name(service: Running, bank: Bank) -> None:
    with Player(service) as player:
        player.do(WALK, {**WALK, "id": 9, "locomotion": "run"}, {"do": "create", "id": [3, 4], "locomotion": "run"})
        assert player.frame()["ids"] == [7, 9, 3, 4]
        done = player.do({"do": "remove", "id": [9, 4]})["frame"]
        assert player.frames_until(done)[-1]["ids"] == [7, 3]
        done = player.do({"do": "speed", "id": [7, 3], "speed": 0.0})["frame"]
        player.frames_until(done + 1)
        one, two = player.frame(), player.frame()
        np.testing.assert_array_equal(one["rotations"], two["rotations"])
        done = player.do({"do": "play", "id": 3, "locomotion": "side_step", "time": 0.5, "blend": 0})["frame"]
        beside = player.frames_until(done)[-1]["rotations"][0, 1]
        wave = {"do": "act", "id": 3, "action": "wave", "method": "naive", "start": 1.0, "blend": 0}
        done = player.do(wave)["frame"]
        frame = player.frames_until(done)[-1]
        upper = bank.skeleton.subtree(bank.roles.pelvis)
        wanted = bank.motion("wave").sampled([1.0 * bank.clip("wave").rate])[1][0, upper]
        np.testing.assert_allclose(frame["rotations"][0, 1][upper], wanted, atol=1e-5)
        done = player.do({"do": "stop", "id": 3, "blend": 0})["frame"]
        np.testing.assert_allclose(player.frames_until(done)[-1]["rotations"][0, 1], beside, atol=1e-6)
        done = player.do({"do": "place", "id": 3, "position": [5, 1, 6]}, {"do": "in_place", "id": 7, "in_place": True})
        frame = player.frames_until(done["frame"])[-1]
        np.testing.assert_allclose(frame["root_positions"][0, :, [0, 2]], [[0, 5], [0, 6]], atol=0.2)


def test_locomotions_are_mixed_by_weight(service: Running) -> None:
    with Player(service) as player:
        first = player.do({**WALK, "locomotion": {"walk": 1, "run": 0}})["frame"]
        walked = speed_ahead(player.frames_until(first + 60))
        assert player.do({"do": "mix", "id": 7, "weights": {"run": 1}})["event"] == "done"
        player.frames_until(first + 90)
        assert speed_ahead(player.frames_until(first + 150)) > 1.3 * walked


def speed_ahead(frames: list[dict[str, Any]]) -> float:
    """Returns how far the first character goes along Z in a frame, on average."""
    return float(np.diff([frame["root_positions"][0, 0, 2] for frame in frames]).mean())


def test_events_come_with_the_frame_that_shows_them(service: Running, bank: Bank) -> None:
    with Player(service) as player:
        reply = player.do({"do": "set", "events": ["left_down", "action_began", "action_ended", "locomotion_ended"]})
        assert reply["event"] == "done"
        near = bank.clip("run").duration - 2.5 / 60.0
        run = {"do": "create", "locomotion": "run", "time": near, "loop": False}
        first = player.do(WALK, {**run, "id": 2})["frame"]
        ended = player.event("locomotion_ended")
        assert (ended["ids"], ended["frame"]) == ([2], first + 3)
        done = player.do({"do": "act", "id": 7, "action": "wave", "when": "left_foot", "loop": False})["frame"]
        down, began = player.event("left_down"), player.event("action_began")
        assert (began["ids"], began["action"]) == ([7], "wave")
        assert done < began["frame"] == down["frame"]
        over = player.event("action_ended")
        assert (over["ids"], over["action"]) == ([7], "wave")
        assert 1.0 < (over["frame"] - began["frame"]) / 60.0 < bank.clip("wave").duration


@pytest.mark.parametrize(
    ("commands", "kind", "words"),
    [
        ([{"do": "create", "id": 8, "locomotion": "wlak"}], "unknown-clip", "Did you mean 'walk'"),
        ([{"do": "create", "id": 7, "locomotion": "walk"}], "request", "character 7 already exists"),
        (
            [{"do": "create", "id": -1, "locomotion": "walk"}],
            "request",
            "id: expected a whole number from 0 to 4294967295, or a list of them that is not empty, found -1",
        ),
        ([{"do": "create", "id": [8, 8], "locomotion": "walk"}], "request", "id: the list has a number twice"),
        ([{"do": "create", "id": 8}], "request", "locomotion: missing, but create requires it"),
        ([{"do": "create", "id": 8, "locomotion": "walk", "sped": 2}], "request", "create has no key 'sped'"),
        ([{"do": "dance", "id": 7}], "request", "unknown command 'dance'"),
        ([{"do": "play", "id": 7, "locomotion": "walk", "time": 99}], "time-range", "Give a time from 0 to 5.000"),
        (
            [{"do": "play", "id": 7, "locomotion": "walk", "time": -1}],
            "request",
            "time: expected at least 0 seconds, found -1",
        ),
        ([{"do": "play", "id": 7, "locomotion": {}}], "request", "0 locomotions cannot be mixed"),
        ([{"do": "mix", "id": 7, "weights": {"run": 1}}], "request", "not one of the locomotions"),
        (
            [{"do": "act", "id": 7, "action": "wave", "own_clock": [1]}],
            "request",
            "own_clock: expected true, false or two times of the action in seconds, found [1]",
        ),
        ([{"do": "set", "events": ["boom"]}], "request", "events: expected a list of left_down"),
        ([{"do": "act", "id": 7, "action": "wave", "start": 9}], "time-range", "start 9 s lies outside clip 'wave'"),
        (
            [{"do": "act", "id": 7, "action": "wave", "posture": "up"}],
            "request",
            f"posture: expected one of {', '.join(get_args(Posture))}, found 'up'",
        ),
        ([{"do": "speed", "id": 6, "speed": 1}], "request", "character 6 not found"),
        ([{"do": "speed", "id": 7, "speed": 9}], "request", "speed: expected a number from 0 to 8, found 9"),
        ([{"do": "set", "rate": 121}], "limit", "rate: 121 is more than 120"),
        ([{"do": "set", "ahead": 121}], "limit", "ahead: 121 is more than 120"),
        ([{"do": "set", "id": 7, "rate": 30}], "request", "set has no key 'id'"),
        (
            [{"do": "create", "id": list(range(10, 400)), "locomotion": "walk"}],
            "busy",
            "at most 20000 characters per second",
        ),
        ([{"do": "remove", "id": 7}, {"do": "remove", "id": 6}], "request", "character 6 not found"),
        ([{"do": "remove", "id": 7}, {"do": "remoov", "id": 6}], "request", "command 1: do: unknown command"),
        ([3], "request", "expected a command, which is a map, found 3"),
        ([{"id": 7}], "request", "do: unknown command None"),
    ],
)
def test_a_message_with_a_wrong_command_is_refused_as_a_whole(
    service: Running, commands: list[Any], kind: str, words: str
) -> None:
    with Player(service) as player:
        player.do(WALK)
        player.frame()
        commands = [{**one, "ref": "mine"} if isinstance(one, dict) else one for one in commands]
        reply = player.do(*commands)
        assert (reply["event"], reply["type"]) == ("refused", f"urn:motionsplice:{kind}")
        assert words in reply["detail"]
        assert reply["ref"] == ("mine" if isinstance(commands[0], dict) else None)
        player.frames.clear()
        assert player.frame()["ids"] == [7]


@pytest.mark.parametrize("ref", [0, -(2**63), 2**64 - 1, 1.5, "", "mine", None])
def test_a_ref_is_repeated(service: Running, ref: Any) -> None:
    with Player(service) as player:
        assert player.do({**WALK, "ref": ref})["ref"] == ref
        refused = player.do({**WALK, "ref": ref})
        assert (refused["event"], refused["ref"]) == ("refused", ref)


@pytest.mark.parametrize("ref", [True, False, {"x": 1}, [], ["mine"]])
def test_a_ref_that_is_not_a_number_or_text_is_refused(service: Running, ref: Any) -> None:
    with Player(service) as player:
        for commands in ([{**WALK, "ref": ref}], [{**WALK, "ref": ref}, {**WALK, "id": 8, "ref": 3}]):
            refused = player.do(*commands)
            assert (refused["event"], refused["ref"]) == ("refused", None)
            assert refused["type"] == "urn:motionsplice:request"
            assert "ref: expected a number or text, found" in refused["detail"]
        later = player.do({**WALK, "ref": 3}, {**WALK, "id": 8, "ref": ref})
        assert (later["event"], later["ref"]) == ("refused", 3)
        assert later["detail"].startswith("command 1: ref: ")
        assert player.do(WALK)["event"] == "done"  # so none of the refused messages created it


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "[" * 30_000, "null", '"x"', "1e999", '{"do": "create", "do": 3}', "[[]]"]
)
def test_text_that_is_not_a_command_is_refused(service: Running, text: str) -> None:
    with Player(service) as player:
        player.socket.send(text)
        assert player.event("done", "refused")["event"] == "refused"
        assert player.do(WALK)["event"] == "done"


def test_frames_sent_ahead_are_the_same_as_frames_sent_one_by_one(service: Running, bank: Bank) -> None:
    with Player(service, "?ahead=20") as player:
        first = player.do(WALK, {"do": "act", "id": 7, "action": "wave", "posture": "running"})["frame"]
        ahead = [player.frame() for _ in range(2)]
        assert [frame["frame"] for frame in ahead] == [first, first + 20]
    with Player(service) as player:
        first = player.do(WALK, {"do": "act", "id": 7, "action": "wave", "posture": "running"})["frame"]
        alone = player.frames_until(first + 30)
    for frame in alone:
        number = frame["frame"] - first
        np.testing.assert_allclose(ahead[number // 20]["rotations"][number % 20], frame["rotations"][0], atol=1e-6)


def test_a_command_replaces_frames_that_were_sent_ahead(service: Running, bank: Bank) -> None:
    with Player(service, "?ahead=60") as player:
        first = player.do(WALK)["frame"]
        sent = player.frame()
        assert (sent["frame"], sent["count"]) == (first, 60)
        done = player.do({"do": "speed", "id": 7, "speed": 0.0, "ref": 5})
        assert done["ref"] == 5
        assert first < done["frame"] < first + 60
        again = player.frame()
        assert again["frame"] == done["frame"]
        held = sent["rotations"][done["frame"] - first, 0]
        np.testing.assert_allclose(again["rotations"][:, 0], np.broadcast_to(held, (60, *held.shape)), atol=1e-6)


def test_rate_and_look_ahead_can_be_changed(service: Running) -> None:
    with Player(service) as player:
        player.do(WALK)
        done = player.do({"do": "set", "rate": 30, "ahead": 4})["frame"]
        frames = player.frames_until(done + 5)
        assert frames[-1]["count"] == 4
        assert frames[-1]["rate"] == 30.0
        assert frames[-1]["time"] - frames[-2]["time"] == pytest.approx(4 / 30, abs=1e-3)


def test_frames_of_all_clients_of_a_rate_are_due_at_the_same_moments(service: Running) -> None:
    with Player(service) as one, Player(service) as two:
        one.do(WALK)
        two.do(WALK)
        apart = [abs(one.frame()["time"] - two.frame()["time"]) * 60.0 for _ in range(5)]
        assert max(abs(part - round(part)) for part in apart) < 0.1


def test_a_newer_bank_is_played_from_the_next_frame_on(service: Running, bank: Bank) -> None:
    hub = service.config.front.hub
    with Player(service) as player:
        player.do(WALK, {"do": "act", "id": 7, "action": "wave"}, {"do": "stop", "id": 7, "blend": 9})
        old = service.config.front.shared.serving.edition
        evaluator = Evaluator(Bank.open(bank.path))
        twin = type(old)(evaluator.bank, evaluator, Stage(evaluator))
        loop = service.server.servers[0].get_loop()
        loop.call_soon_threadsafe(service.config.front.shared.serving.exchange, twin)
        moved = player.event("bank")
        frames = player.frames_until(moved["frame"] + 3)
        numbers = [frame["frame"] for frame in frames]
        assert numbers == sorted(set(numbers))
        assert all(one.play.scene.edition is twin for one in hub.connections)


@pytest.mark.parametrize(
    ("send", "code"),
    [
        (lambda socket: socket.send(b"binary"), 1003),
        (lambda socket: socket.send("x" * 70_000), 1009),
        (lambda socket: socket.socket.sendall(FRAGMENTS), 1009),
        (lambda socket: None, 4408),
    ],
)
def test_it_closes_with_defined_codes(service: Running, send: Any, code: int) -> None:
    player = Player(service)
    send(player.socket)
    with pytest.raises(ConnectionClosed) as caught:
        player.frames_until(10**6)
    assert caught.value.rcvd is not None
    assert caught.value.rcvd.code == code
    eventually(lambda: service.held[2:] == (0, 0))


def test_a_service_that_stops_sends_an_event_and_a_close_code(bank: Bank) -> None:
    with running(bank.path, Settings()) as service:
        player = Player(service)
        player.do(WALK)
        service.server.should_exit = True
        assert "stops" in player.event("closing")["reason"]
        with pytest.raises(ConnectionClosed) as caught:
            player.frames_until(10**6)
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1012
