"""Reading takes memory in proportion to a file, or is refused: also where joints and frames take no bytes in it."""

from __future__ import annotations

import re
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make
from tests.glb_files import edited

PER_BYTE, FREE = 64, 64 * 2**20
CLIP = make("walk", seconds=1.0)


def bvh(frames: int) -> dict[str, bytes]:
    """A body of which only the root has channels."""
    head, _, _ = dump_bvh(CLIP).decode().partition("MOTION")
    begin, root, rest = head.partition("Yrotation\n")
    rest = re.sub("CHANNELS .*", "CHANNELS 0", rest)
    values = f"MOTION\nFrames: {frames}\nFrame Time: 0.033333\n" + "0 0 0 0 0 0\n" * frames
    return {"clip.bvh": (begin + root + rest + values).encode()}


def glb(frames: int) -> dict[str, bytes]:
    """A body with keys at the first frame and at the last only, whose joints all move on their parents."""
    data = dump_glb(replace(CLIP.frames(0, 2), rate=30.0 / frames))

    def edit(document: dict[str, Any]) -> None:
        channels = document["animations"][0]["channels"]
        path = next(channel for channel in channels if channel["target"]["path"] == "translation")
        nodes = {channel["target"]["node"] for channel in channels} - {path["target"]["node"]}
        channels += [{**path, "target": {"node": node, "path": "translation"}} for node in nodes]

    return {"clip.glb": edited(data, edit)}


def amc(frames: int) -> dict[str, bytes]:
    """A hundred bones, of which only the root has values."""
    names = [f"bone{number}" for number in range(100)]
    bones = [
        f"begin\nid {n + 1}\nname {name}\ndirection 0 1 0\nlength 2\naxis 0 0 0 XYZ\nend\n"
        for n, name in enumerate(names)
    ]
    root = ":root\norder TX TY TZ RX RY RZ\naxis XYZ\nposition 0 0 0\norientation 0 0 0\n"
    tree = ":hierarchy\nbegin\n" + "root " + " ".join(names) + "\nend\n"
    asf = ":version 1.10\n:units\nmass 1.0\nlength 0.45\nangle deg\n" + root + ":bonedata\n" + "".join(bones) + tree
    motion = ":FULLY-SPECIFIED\n:DEGREES\n" + "".join(f"{n}\nroot 0 0 0 0 0 0\n" for n in range(1, frames + 1))
    return {"clip.asf": asf.encode(), "clip.amc": motion.encode()}


@pytest.mark.parametrize("make_files", [bvh, glb, amc])
def test_memory_is_in_proportion_to_the_file(make_files: Callable[[int], dict[str, bytes]], tmp_path: Path) -> None:
    refused, read, frames = 0, 0, 1000
    while not refused:
        frames = frames * 5 // 4
        for name, data in make_files(frames).items():
            (tmp_path / name).write_bytes(data)
        tracemalloc.start()
        try:
            read_clip(tmp_path / name)
            read += 1
        except FormatError as error:
            assert re.search(r"clip\.(bvh|glb|amc): .* take too much memory", str(error))  # noqa: PT017
            refused += 1
        except MotionError:  # these bones are no body
            read += 1
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak <= PER_BYTE * sum(file.stat().st_size for file in tmp_path.iterdir()) + FREE, (frames, peak)
    assert read > 3
