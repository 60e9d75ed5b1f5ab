"""GLB, glTF and VRMA files: sound documents with other values at any depth, in sound and unsound containers."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from bench.hostile.damage import damage_bytes, damage_gltf
from bench.hostile.good_files import Good, good_files
from motionsplice.motion.formats.files import clips_in, files_behind
from motionsplice.motion.formats.reading import read_clip
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw
from tests.hardening.fuzz.held import held

MOST_CLIPS = 3  # read from one file


@cache
def _goods() -> list[Good]:
    return good_files("gltf", None)


def make(draw: Draw) -> Files:
    """Returns a file."""
    (item,) = draw.choice(_goods()).files.items()
    name, data = item
    (other,) = draw.choice(_goods()).files.values()
    if draw.randrange(8):
        data = damage_gltf(data, other if other[:4] == data[:4] else data, draw)
    return {name: damage_bytes(data, other, draw) if draw.rarely(4) else data}


def enter(files: Files, folder: Path) -> None:
    """Reads the first clips of the file."""
    (file,) = held(files, folder).values()
    files_behind(file)
    for animation in list(clips_in(file).values())[:MOST_CLIPS]:
        read_clip(file, animation=animation)


EARLY = re.compile(
    "its JSON cannot|this is not a glTF|the file ends after|its header says|the file has no JSON|it has v"
)
DOOR = Door(make, enter, EARLY)
