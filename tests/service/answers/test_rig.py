"""POST /v1/take with the rig of a character."""

from __future__ import annotations

import base64
import time
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from fastapi.testclient import TestClient
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion.formats.character import parse_character
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.hand_rig import FINGERED
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.retarget.rig import Rig
from motionsplice.runtime.bank import Bank
from motionsplice.service.answers.rig import MOST_NODES
from tests.characters import character_file
from tests.glb_files import edited
from tests.service.messages import blob_offsets
from tests.vrm_characters import vrm_character

FRAMES = 90
COMMANDS = [{"do": "create", "locomotion": "walk"}, {"do": "act", "action": "wave"}]
HERO = character_file(FINGERED.scaled(0.8), seed=1, scale=100.0)


def order(rig: bytes | str | None, frames: int = FRAMES) -> dict[str, Any]:
    text = base64.b64encode(rig).decode() if isinstance(rig, bytes) else rig
    return {"rate": 60, "frames": frames, "commands": COMMANDS} | ({} if text is None else {"rig": text})


def taken_as_clip(client: TestClient, folder: Path) -> Any:
    (folder / "take.bvh").write_bytes(client.post("/v1/take?format=bvh", json=order(None)).content)
    return read_clip(folder / "take.bvh", unit="m")


@pytest.mark.parametrize("rig", [HERO, vrm_character()], ids=["skin", "vrm"])
def test_its_nodes_move_as_the_command_line_writes_them(client: TestClient, tmp_path: Path, rig: bytes) -> None:
    answer = client.post("/v1/take?format=msgpack&axes=unity&encoding=int16", json=order(rig))
    assert answer.is_success, answer.text
    assert not any(offset % 4 for offset in blob_offsets(answer.content).values())
    found = msgpack.unpackb(answer.content)
    nodes = found["rig"]
    translations = np.frombuffer(found["node_translations"], "<f4").reshape(FRAMES, len(nodes["moved"]), 3)
    rotations = np.frombuffer(found["node_rotations"], "<f4").reshape(FRAMES, len(nodes["turned"]), 4)
    taken, character = taken_as_clip(client, tmp_path), parse_character(rig)
    clip = onto_rig(taken.clip, taken.roles, Rig(character.skeleton, character.roles)).clip
    moved, turned = character.keys(clip)
    still = {(path, one["node"]): one[path] for one in nodes["still"] for path in one if path != "node"}
    for path, expected, listed, keys in (
        ("translation", moved, nodes["moved"], translations),
        ("rotation", turned, nodes["turned"], rotations),
    ):
        assert set(expected) == {*listed, *(node for other, node in still if other == path)}
        for node, rows in expected.items():
            got = keys[:, listed.index(node)] if node in listed else np.array([still[path, node]])
            if path == "rotation":
                got = got * np.sign(np.sum(got * rows, axis=-1, keepdims=True))
            np.testing.assert_allclose(got, rows, atol=1e-4 * max(1.0, np.abs(rows).max()))


def test_legs_are_as_long_as_those_of_the_bank(client: TestClient, bank: Bank) -> None:
    scale = client.post("/v1/take", json=order(HERO, 3)).json()["rig"]["scale"]
    character = parse_character(HERO)
    legs = character.roles.leg_length(character.skeleton), bank.roles.leg_length(bank.skeleton)
    assert scale * legs[0] == pytest.approx(legs[1])


def test_it_is_the_motion_of_the_bank_as_well(client: TestClient) -> None:
    with_rig, without = (client.post("/v1/take", json=order(rig, 20)).json() for rig in (HERO, None))
    assert with_rig.keys() - without.keys() == {"rig", "node_rotations", "node_translations"}
    assert without.items() <= with_rig.items()


def test_it_is_written_into_a_copy_of_the_rig(client: TestClient, tmp_path: Path) -> None:
    answer = client.post("/v1/take?format=glb", json=order(HERO))
    assert answer.headers["content-disposition"] == 'attachment; filename="walk+wave.glb"'
    (tmp_path / "hero.glb").write_bytes(answer.content)
    clip = read_clip(tmp_path / "hero.glb").clip
    taken, character = taken_as_clip(client, tmp_path), parse_character(HERO)
    expected = onto_rig(taken.clip, taken.roles, Rig(character.skeleton, character.roles)).clip
    assert clip.name == "hero"
    np.testing.assert_allclose(joint_positions(clip), joint_positions(expected), atol=1e-4)


def test_slashes_in_base64_may_be_escaped(client: TestClient) -> None:
    text = base64.b64encode(HERO + b"\xff" * 60).decode()
    assert "//" in text
    body = f'{{"frames": 2, "commands": [{{"do": "create", "locomotion": "walk"}}], "rig" : "{text}"}}'
    json = {"content-type": "application/json"}
    for one in (body, body.replace("/", "\\/")):
        answer = client.post("/v1/take", content=one, headers=json)
        assert answer.is_success, answer.text


def unnamed(document: dict[str, Any]) -> None:
    for number, node in enumerate(document["nodes"]):
        node["name"] = f"bone {number}"


def crowded(document: dict[str, Any]) -> None:
    document["nodes"] += [{}] * MOST_NODES


def flat(document: dict[str, Any]) -> None:
    for node in document["nodes"]:
        node["translation"] = [0, 0, 0]


@pytest.mark.parametrize(
    ("rig", "kind", "detail"),
    [
        (b"BVH", "rig", "rig: this is not a GLB file. Export the character as .glb or .vrm"),
        (b"", "rig", "rig: this is not a GLB file"),
        (HERO[:500], "rig", "its header says"),
        (edited(HERO, unnamed), "rig", "rig: no joint found for left_hip"),
        (edited(HERO, lambda document: document.pop("skins")), "rig", "rig: no skeleton found"),
        (edited(HERO, lambda document: document.pop("nodes")), "rig", "rig: the file is malformed: KeyError 'nodes'"),
        (edited(HERO, lambda document: document.update(asset=[])), "rig", "rig: the file is malformed"),
        (edited(HERO, crowded), "rig", f"nodes, more than {MOST_NODES}. Leave out"),
        ("not base64!", "request", "rig: expected the bytes of a GLB file as text in base64"),
        ("abc", "request", "rig: this is not base64"),
        (7, "request", "rig: expected"),
    ],
)
def test_rigs_that_it_cannot_move_are_refused(client: TestClient, rig: Any, kind: str, detail: str) -> None:
    answer = client.post("/v1/take", json=order(rig, 3))
    assert answer.status_code == 422
    assert answer.json()["type"] == f"urn:motionsplice:{kind}"
    assert detail in answer.json()["detail"]


def test_a_rig_without_lengths_is_refused(client: TestClient) -> None:
    answer = client.post("/v1/take", json=order(edited(vrm_character(), flat), 3))
    assert answer.status_code == 422, answer.text
    assert answer.json()["type"] == "urn:motionsplice:rig"


def test_sizes_are_limited(client: TestClient) -> None:
    too_large = client.post("/v1/take", json=order(bytes(2**20 + 3), 3))
    assert too_large.status_code == 413
    assert "rig: more than 1048576 bytes" in too_large.json()["detail"]
    body = b'{"frames": 1, "x": [' + b"[]," * 400_000 + b"[]]}"
    began = time.process_time()
    assert client.post("/v1/take", content=body, headers={"content-type": "application/json"}).status_code == 413
    assert time.process_time() - began < 0.5  # it is not parsed
    many = {**order(HERO), "frames": 5000, "rate": 1000}

    def long(document: dict[str, Any]) -> None:
        hair = range(len(document["nodes"]), len(document["nodes"]) + 300)
        document["nodes"] += [{"name": f"hair {node}", "translation": [0, 0.01, 0]} for node in hair]
        document["nodes"][4]["children"] = [*document["nodes"][4].get("children", ()), *hair]
        document["skins"].append({"joints": list(hair)})

    answer = client.post("/v1/take", json={**many, "rig": order(edited(HERO, long))["rig"]})
    assert answer.status_code == 422
    assert "joints are more than 1000000 transforms. Ask for fewer frames" in answer.json()["detail"]


@pytest.mark.parametrize("form", ["bvh", "gltf", "vrma"])
def test_other_files_have_no_rig(client: TestClient, form: str) -> None:
    answer = client.post(f"/v1/take?format={form}", json=order(HERO, 3))
    assert answer.status_code == 422
    assert f"format: a rig cannot be written as {form}. Ask for json, msgpack or glb" in answer.json()["detail"]


@given(st.data())
@settings(max_examples=150)
def test_a_damaged_rig_is_refused_or_moved(client: TestClient, data: st.DataObject) -> None:
    document, binary = read_document(HERO)
    start = len(HERO) - len(binary)
    size = document["bufferViews"][document["accessors"][document["skins"][0]["inverseBindMatrices"]]["bufferView"]]
    damaged = bytearray(HERO)
    for _ in range(data.draw(st.integers(1, 4))):
        at = st.integers(0, start) if data.draw(st.booleans()) else st.integers(start, start + size["byteLength"] - 1)
        damaged[data.draw(at)] = data.draw(st.integers(0, 255))
    assert client.post("/v1/take?format=msgpack", json=order(bytes(damaged), 2)).status_code in (200, 422)
