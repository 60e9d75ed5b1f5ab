"""What a client may ask for: axes of commands and frames, root motion, and frames as JSON."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion.axes import AXES, Axes
from motionsplice.service.characters.commands import checked
from motionsplice.service.settings import Settings
from tests.service.characters.player import Player
from tests.service.running import Running, running

TURN = {"do": "create", "id": 7, "locomotion": "turn_180", "time": 1.0}
AHEAD = {"gltf": [0, 0, 1], "unity": [0, 0, 1], "unreal": [1, 0, 0], "godot": [0, 0, 1], "blender": [0, -1, 0]}
UP = {"gltf": [0, 1, 0], "unity": [0, 1, 0], "unreal": [0, 0, 1], "godot": [0, 1, 0], "blender": [0, 0, 1]}
every = pytest.mark.parametrize("axes", AXES.values(), ids=AXES.keys())
places = st.lists(st.floats(-1e4, 1e4), min_size=3, max_size=3)


@every
@given(place=places, heading=st.floats(-10.0, 10.0))
def test_commands_are_in_the_clients_axes(axes: Axes, place: list[float], heading: float) -> None:
    fields = {"do": "place", "id": 7, "position": place, "heading": heading}
    (command,) = checked([fields], axes)
    ours = np.array(command.values["position"])
    np.testing.assert_allclose(axes.positions(ours), place, atol=1e-9)
    angle = command.values["heading"]
    facing = axes.positions(np.array([np.sin(angle), 0.0, np.cos(angle)])) / axes.scale
    theirs = Rotation.from_rotvec(heading * np.array(UP[axes.name], float)).apply(AHEAD[axes.name])
    np.testing.assert_allclose(facing, theirs, atol=1e-9)  # a quaternion turns alike in left-handed axes


@pytest.mark.parametrize("query", ["", "&format=json", "&format=json&encoding=int16", "&encoding=int16"])
@every
def test_a_character_is_where_it_is_placed_in_any_format(service: Running, axes: Axes, query: str) -> None:
    with Player(service, f"?axes={axes.name}&parts=both&deltas=true{query}") as player:
        place = [3.0 * axes.scale, 2.0 * axes.scale, 1.0 * axes.scale]
        done = player.do({**TURN, "position": place, "heading": 0.4}, {"do": "speed", "id": 7, "speed": 0})
        frame = player.frames_until(done["frame"])[-1]
        across = [axis for axis in range(3) if not UP[axes.name][axis]]
        root = frame["root_positions"][0, 0]
        np.testing.assert_allclose(root[across], np.array(place)[across], atol=0.2 * axes.scale)
        error = np.abs(joints(frame, player.welcome) - frame["world_positions"][0, 0]).max() / axes.scale
        assert error < (3e-4 if "int16" in query else 2e-6)


def joints(frame: dict[str, Any], welcome: dict[str, Any]) -> Any:
    """Returns the joints of a frame's character, placed as the protocol describes."""
    rotations = np.array(frame["rotations"][0, 0], float)
    turns = Rotation.from_quat(rotations)  # which normalises
    places: list[Any] = [frame["root_positions"][0, 0]]
    world = [turns[0]]
    for joint, parent in enumerate(welcome["parents"][1:], 1):
        places.append(places[parent] + world[parent].apply(welcome["offsets"][joint]))
        world.append(world[parent] * turns[joint])
    return np.array(places)


@every
@pytest.mark.parametrize("ahead", [1, 7])
def test_root_motion_adds_up_to_where_a_character_is(service: Running, axes: Axes, ahead: int) -> None:
    """A client that moves and turns its own character by the root motion arrives at the same place."""
    path = f"?axes={axes.name}&deltas=true&rate=120&ahead={ahead}&encoding=int16"
    with Player(service, path) as player:
        begun = player.do({**TURN, "heading": 0.5, "position": [1, 2, 3]})["frame"]
        frames = player.frames_until(begun + 120)
        start = np.array([1.0, 2.0, 3.0])
        at, turn = start, 0.5
        for frame in frames:
            for number in range(frame["count"]):
                facing = Rotation.from_rotvec(turn * np.array(UP[axes.name], float))
                at = at + facing.apply(frame["root_steps"][number, 0])
                turn += frame["root_turns"][number, 0]
        last = frames[-1]["frame"] + frames[-1]["count"] - 1
        done = player.do({**TURN, "id": 8, "in_place": True})["frame"]
        swaying = player.frames_until(done + last - begun)
        number = done + last - begun - swaying[-1]["frame"]
        sway = swaying[-1]["root_positions"][number, 1]
        here = Rotation.from_rotvec(turn * np.array(UP[axes.name], float)).apply(sway)
        np.testing.assert_allclose(at + here, frames[-1]["root_positions"][-1, 0], atol=1e-4 * axes.scale)
        assert np.linalg.norm(at - start) > 0.5 * axes.scale
        assert abs(turn - 0.5) > 0.4
        np.testing.assert_array_equal(frames[0]["root_steps"][0], np.zeros((1, 3)))


@every
@pytest.mark.parametrize("query", ["", "&format=json"])
def test_far_from_the_origin_positions_are_precise_relative_to_an_origin(
    service: Running, axes: Axes, query: str
) -> None:
    far = [50_000.0 * axes.scale] * 3
    with Player(service, f"?axes={axes.name}&parts=both&origins=true{query}") as player:
        done = player.do({**TURN, "position": far}, {"do": "speed", "id": 7, "speed": 0}, {**TURN, "id": 8})
        frame = player.frames_until(done["frame"])[-1]
        origins = frame["root_origins"][0] / axes.scale
        np.testing.assert_array_equal(origins, 256.0 * np.round(origins / 256.0))
        for name in ("root_positions", "world_positions"):
            relative, near = frame[name][0].reshape(2, -1, 3)
            there = np.array(frame["root_origins"][0, 0], float) + relative
            np.testing.assert_allclose(there - far, near, atol=3e-5 * axes.scale)


def test_frames_without_deltas_have_no_root_motion(service: Running) -> None:
    with Player(service) as player:
        player.do(TURN)
        assert player.frame().keys() == {"bank", "frame", "count", "rate", "time", "ids", "root_positions", "rotations"}


def test_frames_as_json_are_the_same_and_fewer(service: Running) -> None:
    with Player(service, "?parts=both&ahead=3&deltas=true") as binary, Player(
        service, "?parts=both&ahead=3&deltas=true&format=json"
    ) as text:  # fmt: skip
        binary.do(TURN, {**TURN, "id": [1, 2]})
        text.do(TURN, {**TURN, "id": [1, 2]})
        one, other = binary.frame(), text.frame()
        assert other.pop("event") == "frames"
        assert one.keys() == other.keys()
        for name in ("bank", "count", "rate", "ids"):
            assert one[name] == other[name]
        for name in ("root_positions", "root_steps", "root_turns", "rotations", "world_positions"):
            np.testing.assert_allclose(one[name], other[name], atol=1e-6)
            assert one[name].shape == other[name].shape
        assert (binary.welcome["format"], text.welcome["format"]) == ("msgpack", "json")
        assert (binary.welcome["max_characters"], text.welcome["max_characters"]) == (10_000, 625)
        refused = text.do({**TURN, "id": list(range(100, 310))})
        assert refused["detail"].endswith("Ask for at most 625 characters times frames")


def test_frames_as_json_count_sixteen_times_towards_the_load(service: Running) -> None:
    with Player(service, "?format=json&rate=60") as player:
        refused = player.do({**TURN, "id": list(range(21))})  # 21 * 60 * 16 exceed 20,000
        assert refused["type"] == "urn:motionsplice:busy"
        assert player.do({**TURN, "id": list(range(20))})["event"] == "done"


def test_a_slow_client_of_json_gets_whole_messages(bank: Any) -> None:
    with running(bank.path, Settings()) as service, Player(service, "?format=json&rate=120&ahead=4") as player:
        player.do({**TURN, "id": list(range(150))})
        frames = [player.frame() for _ in range(30)]
        assert all(len(frame["ids"]) == 150 for frame in frames)
