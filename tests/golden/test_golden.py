"""The golden files are what the service sends today, and a client can pose a rig from them alone."""

from __future__ import annotations

import json
import runpy
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bench.clips import bank_of
from tests.service.messages import arrays, blob_offsets, unpacked

FILES = Path(__file__).with_name("files")
INDEX = json.loads((FILES / "index.json").read_text())
SCALES = {"unreal": 100.0}  # units of a metre
KEYS = ("root_positions", "root_steps", "root_turns", "rotations", "world_positions", "ids")


def decoded(file: Path, rig: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns the messages of a file: arrays [F, n, ...] by key, int16 as numbers from -1 to 1, and other fields."""
    short = "int16" in file.name or file.name.startswith("splice")
    if file.suffix == ".json":
        fields = json.loads(file.read_text())
        found = {key: np.array(value) for key, value in fields.items() if key in KEYS}
        if short:
            found["rotations"] = np.maximum(found["rotations"] / 32767.0, -1.0)
        return [{**fields, **found}]
    messages = unpacked(file.read_bytes()) if file.suffix == ".bin" else [msgpack.unpackb(file.read_bytes())]
    answers = []
    for fields in messages:
        ids = {"ids": np.frombuffer(fields["ids"], "<u4")} if "ids" in fields else {}
        leading = {"characters": (2, 2), "pose": (), "poses": (3,)}.get(file.name.partition(".")[0])
        leading = (fields["count"],) if leading is None and "count" in fields else leading or ()
        answers.append({**fields, **arrays(fields, len(rig["joints"]), *leading, short=short), **ids})
    return answers


@pytest.mark.parametrize("entry", INDEX, ids=lambda entry: entry["file"])
def test_joints_placed_by_a_files_rotations_are_at_its_world_positions(entry: dict[str, Any]) -> None:
    rig = json.loads((FILES / entry["rig"]).read_text())
    for message in decoded(FILES / entry["file"], rig):
        if "rotations" not in message:
            continue  # the header of a stream
        count = len(rig["joints"])
        rotations = message["rotations"].reshape(-1, count, 4)
        worlds = message["world_positions"].reshape(-1, count, 3)
        roots = message["root_positions"].reshape(-1, 3)
        for root, turns, world in zip(roots, rotations, worlds, strict=True):
            places, frames = [root], [Rotation.from_quat(turns[0])]
            for joint, parent in enumerate(rig["parents"][1:], 1):
                places.append(places[parent] + frames[parent].apply(rig["offsets"][joint]))
                frames.append(frames[parent] * Rotation.from_quat(turns[joint]))
            most = 1e-4 if "int16" in entry["request"] else 1e-5
            assert np.abs(np.array(places) - world).max() < most * SCALES.get(rig.get("axes", ""), 1.0)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("golden")
    (folder / "files").mkdir()
    write = runpy.run_path(str(Path(__file__).with_name("__main__.py")))["write"]
    write(bank_of(None, "walk", folder / "bank"), folder / "files")
    return folder / "files"


def test_the_files_are_those_of_the_command(made: Path) -> None:
    assert json.loads((made / "index.json").read_text()) == INDEX, "run python -m tests.golden"
    assert {file.name for file in FILES.iterdir()} == {file.name for file in made.iterdir()}
    assert sum(file.stat().st_size for file in FILES.iterdir()) < 300_000
    for axes in ("gltf", "unity", "unreal", "godot", "blender"):
        ours, theirs = (json.loads((folder / f"rig.{axes}.json").read_text()) for folder in (FILES, made))
        assert {**ours, "bank": ""} == {**theirs, "bank": ""}


@pytest.mark.parametrize("entry", INDEX, ids=lambda entry: entry["file"])
def test_the_files_are_what_the_service_sends(made: Path, entry: dict[str, Any]) -> None:
    """To the digits that other processors give, and but for the bank's digest, which may differ there."""
    rig = json.loads((FILES / entry["rig"]).read_text())
    for ours, theirs in zip(decoded(FILES / entry["file"], rig), decoded(made / entry["file"], rig), strict=True):
        assert list(ours) == list(theirs)
        for key, value in ours.items():
            if isinstance(value, np.ndarray):
                np.testing.assert_allclose(value, theirs[key], atol=1e-3 if rig["axes"] == "unreal" else 1e-4)
            elif key != "bank":
                assert value == theirs[key], key
    if entry["file"].endswith(".msgpack"):
        assert blob_offsets((FILES / entry["file"]).read_bytes()) == blob_offsets((made / entry["file"]).read_bytes())
