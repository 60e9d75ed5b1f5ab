"""Writes the golden files, from which clients in other languages are tested: `python -m tests.golden`.

`index.json` lists them, with the request that each answers. They hold answers for the built-in motions, as MessagePack
and as JSON, in all axes and number formats, always with the world positions of all joints. So a client can decode a
file, place the joints by rotations and offsets, and compare. `time` is made up, and the first frame is number 120.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import orjson
from fastapi.testclient import TestClient

from bench.clips import bank_of
from motionsplice.motion.axes import AXES
from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.characters.commands import checked, parse
from motionsplice.service.characters.frame_format import FrameFormat
from motionsplice.service.characters.scene import Scene
from motionsplice.service.serving import Edition
from motionsplice.service.wire.encoding import NUMBERS, Arrays, Encoding

FILES = Path(__file__).with_name("files")
PATIENCE = 600.0  # seconds, if kernels are compiled for the first time
COMMANDS = [
    {"do": "create", "id": 7, "locomotion": "curve", "position": [1, 2, 3], "heading": 0.5},
    {"do": "create", "id": 4294967295, "locomotion": {"walk": 1, "run": 2}, "time": 0.5},
    {"do": "act", "id": 4294967295, "action": "carry_box"},
]
RATE, FIRST, AHEAD, TIME = 60.0, 120, 2, 1_800_000_000.25
BATCH = {"clips": ["walk", "wave"], "locomotion": [0, 0, 0], "action": [1, -1, 1], "time": [0.5, 0.5, 1.25]}
REQUESTS = {
    "pose": "/v1/pose?locomotion=walk&action=wave&time=0.5&parts=both",
    "splice": "/v1/splice?locomotion=run&action=carry_box&first=10&count=3&parts=both&encoding=int16",
}


def main() -> None:
    """Writes all golden files."""
    with tempfile.TemporaryDirectory() as folder:
        write(bank_of(None, "walk", Path(folder)), Path(sys.argv[1]) if len(sys.argv) > 1 else FILES)


def write(bank: Bank, folder: Path) -> None:
    """Writes all golden files into a folder."""
    edition, index = Edition.warm(bank), []
    for axes in AXES.values():
        rig = {**edition.rig(axes), "axes": axes.name, "clips": edition.clips}
        (folder / f"rig.{axes.name}.json").write_bytes(orjson.dumps(rig))
        for numbers in NUMBERS:
            for form, suffix in (("msgpack", "msgpack"), ("json", "json")):
                wanted = FrameFormat(Encoding(axes, numbers, "both"), deltas=True, form=form)
                query = "&".join(f"{name}={value}" for name, value in wanted.fields.items() if value is not False)
                name = f"characters.{axes.name}.{numbers}.{suffix}"
                (folder / name).write_bytes(_message(edition, wanted))
                request = f"/v1/characters?rate={RATE:g}&ahead={AHEAD}&{query}".replace("True", "true")
                index.append({"file": name, "rig": f"rig.{axes.name}.json", "request": request, "commands": COMMANDS})
    for name, request, body, answer in _answers(bank):
        (folder / name).write_bytes(answer)
        index.append({"file": name, "rig": "rig.gltf.json", "request": request, "body": body})
    (folder / "index.json").write_bytes(orjson.dumps(index, option=orjson.OPT_INDENT_2))


def _message(edition: Edition, form: FrameFormat) -> bytes:
    """Returns frames FIRST and FIRST + 1 after the commands, in one message."""
    scene, frames = Scene(edition, RATE, 10), list[Arrays]()
    for command in checked(parse(orjson.dumps(COMMANDS).decode()), form.encoding.axes):
        scene.do(command)
    for _ in range(FIRST):
        scene.pass_frame()
    for _ in range(AHEAD):
        poses = edition.evaluator.poses(len(scene))
        scene.evaluate(poses)
        arrays = {**form.motion(scene.characters), **form.encoding.arrays(edition.evaluator, poses)}
        frames.append({name: np.array(one) for name, one in arrays.items()})
        list(scene.advance())
    return form.writer(edition.bank.digest, RATE, frames)(FIRST, TIME, scene.ids, 0, len(scene))


def _answers(bank: Bank) -> Iterator[tuple[str, str, Any, bytes]]:
    """Yields file name, request, body and answer of requests over HTTP."""
    with TestClient(create_app(bank)) as client:
        deadline = time.monotonic() + PATIENCE
        while client.get("/readyz").status_code == 503:
            assert time.monotonic() < deadline
        for form in ("msgpack", "json"):
            for name, request in REQUESTS.items():
                query = f"{request}&format={form}"
                yield f"{name}.{form}", query, None, client.get(query).content
            query = f"/v1/poses?parts=both&format={form}"
            yield f"poses.{form}", query, BATCH, client.post(query, json=BATCH).content
        query = "/v1/stream?locomotion=run&action=carry_box&first=10&count=3&ahead=2&parts=both"
        yield "stream.bin", query, None, client.get(query).content


if __name__ == "__main__":
    main()
