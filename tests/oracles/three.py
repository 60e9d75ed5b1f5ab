"""World transforms by three.js, and their comparison with a scene's."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motionsplice.motion.formats.scene import Scene
from motionsplice.motion.quaternion import Floats
from tests.oracles.node import run

CLOSE = 1e-5  # of the rig's size
RIGS = Path(__file__).parents[3] / "shared" / "mocap" / "rigs"


@dataclass(frozen=True, eq=False)
class Worlds:
    """Transforms [F, N, 3, 4] of named nodes, and where all keys that move a node are at a frame's time [F, N]."""

    names: list[str]
    transforms: Floats
    keyed: NDArray[np.bool_]


def three_worlds(file: Path, scenes: Sequence[Scene]) -> list[Worlds]:
    """Returns the worlds of a file's animations at the frames of the scenes that were made of them."""
    frames = [{"frames": len(scene.world), "rate": scene.rate} for scene in scenes]
    names, *animations = run("three_worlds.mjs", file, json.dumps(frames))
    found = []
    for one in animations:
        matrices = np.reshape(one["worlds"], (len(one["worlds"]), len(names), 4, 4))
        found.append(Worlds(names, matrices.transpose(0, 1, 3, 2)[:, :, :3], np.array(one["keyed"])))
    assert len(found) == len(scenes)
    return found


def assert_close(ours: Floats, theirs: Floats, among: NDArray[np.bool_] | None = None) -> None:
    """Checks positions against the rig's size, and axes against the longest one; where `among` [F, N] is true."""
    size, longest = np.ptp(theirs[0, ..., 3], axis=0).max(), np.abs(theirs[..., :3]).max()
    off = np.abs(ours - theirs).max(axis=2)[... if among is None else among]
    assert off[..., 3].max() < CLOSE * size
    assert off[..., :3].max() < CLOSE * longest


def shared_rig(name: str) -> Path:
    """Returns a rig that is not part of the project; skips the test if it is missing."""
    if not (RIGS / name).exists():
        pytest.skip(f"{name} not found (../shared/mocap/rigs)")
    return RIGS / name
