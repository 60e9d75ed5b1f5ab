"""Every glTF file that we write, by Khronos' validator: no errors and no warnings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.files import write_clip
from motionsplice.motion.procedural.gestures import sample_gestures
from motionsplice.motion.procedural.library import sample_clips
from motionsplice.motion.roles import find_roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.bank import Bank
from tests.oracles.node import needs_node, run

SUFFIXES = (".glb", ".gltf", ".vrma")  # that are written


@needs_node
def test_written_files_are_valid(bank: Bank, tmp_path: Path) -> None:
    clips = sample_clips() | sample_gestures()
    walk = clips["walk"]
    names = tuple(f'骨 "{name}" \\ é\n' for name in walk.skeleton.names)
    bare = Skeleton(names, walk.skeleton.parents, walk.skeleton.offsets, np.zeros(0, np.int64), np.zeros((0, 3)))
    clips |= {
        "one frame": walk.frames(5, 6),
        "other scripts": Clip("ходьба", bare, 29.97, walk.root_positions, walk.rotations),
        "far away": replace(walk, root_positions=walk.root_positions + np.array([9e4, -9e4, 0.0])),
        "from a bank": bank.motion("carry_box"),
    }
    files = []
    for suffix in SUFFIXES:
        for name, clip in clips.items():
            files.append(str(tmp_path / f"{name}{suffix}"))
            write_clip(Path(files[-1]), clip, find_roles(clip.skeleton))
    found = dict(zip(files, run("validate.mjs", *files), strict=True))
    assert {file: issues for file, issues in found.items() if issues} == {}
