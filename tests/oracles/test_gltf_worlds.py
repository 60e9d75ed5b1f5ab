"""World transforms of glTF files against three.js's GLTFLoader, in every frame."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bench.hostile.good_files import with_data
from bench.hostile.rich_gltf import rich_document
from motionsplice.motion.formats.files import read_bytes
from motionsplice.motion.formats.gltf.reader import animation_names, read_scene
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.formats.scene import Scene
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from tests.glb_files import with_animation
from tests.oracles.node import needs_node, run

pytestmark = needs_node
CLOSE = 1e-5  # of the rig's size
RIGS = Path(__file__).parents[3] / "shared" / "mocap" / "rigs"

WALK = make("walk", "wave", seed=1, seconds=4.0)
MADE: dict[str, bytes] = {
    "walk.glb": dump_glb(WALK),
    "two.glb": with_animation(dump_glb(WALK), WALK.frames(40, 100)),
    "one_frame.glb": dump_glb(WALK.frames(3, 4)),
    "rich.gltf": with_data(*rich_document(WALK.frames(0, 12))),
}


def worlds(file: Path) -> list[tuple[Scene, Floats]]:
    """Returns each animation's scene, and the worlds [F, N, 3, 4] of its nodes by three.js."""
    data = file.read_bytes()
    scenes = [read_scene(data, lambda name: read_bytes(file.parent / name), name) for name in animation_names(data)]
    frames = [{"frames": len(scene.world), "rate": scene.rate} for scene in scenes]
    names, *matrices = run("three_worlds.mjs", file, json.dumps(frames))
    assert all(list(scene.names) == names for scene in scenes)
    found = [np.reshape(theirs, (len(theirs), -1, 4, 4)).transpose(0, 1, 3, 2)[:, :, :3] for theirs in matrices]
    return list(zip(scenes, found, strict=True))


def check(file: Path) -> None:
    for scene, theirs in worlds(file):
        off = np.abs(scene.world - theirs).max(axis=(0, 1))
        assert off[:, 3].max() < CLOSE * np.ptp(theirs[0, ..., 3], axis=0).max()
        assert off[:, :3].max() < CLOSE * np.abs(theirs[..., :3]).max()


@pytest.mark.parametrize("name", MADE)
def test_nodes_of_made_files_are_where_three_has_them(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(MADE[name])
    check(tmp_path / name)


@pytest.mark.parametrize("name", ["robot.glb", "m2m-human-addon-animations.glb"])
def test_nodes_of_other_peoples_files_are_where_three_has_them(name: str) -> None:
    if not (RIGS / name).exists():
        pytest.skip(f"{name} not found (../shared/mocap/rigs)")
    check(RIGS / name)


def test_joints_of_a_clip_are_where_three_has_them(tmp_path: Path) -> None:
    (tmp_path / "walk.glb").write_bytes(MADE["walk.glb"])
    ((scene, theirs),) = worlds(tmp_path / "walk.glb")
    clip = read_clip(tmp_path / "walk.glb").clip
    order = [scene.names.index(name) for name in clip.skeleton.names]
    size = np.ptp(theirs[0, ..., 3], axis=0).max()
    assert np.abs(joint_positions(clip) - theirs[..., 3][:, order]).max() < CLOSE * size
