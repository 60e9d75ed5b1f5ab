"""World transforms of glTF files against three.js's GLTFLoader, in every frame."""

from __future__ import annotations

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
from tests.glb_files import with_animation
from tests.oracles.node import needs_node
from tests.oracles.three import CLOSE, assert_close, shared_rig, three_worlds

pytestmark = needs_node

WALK = make("walk", "wave", seed=1, seconds=4.0)
MADE: dict[str, bytes] = {
    "walk.glb": dump_glb(WALK),
    "two.glb": with_animation(dump_glb(WALK), WALK.frames(40, 100)),
    "one_frame.glb": dump_glb(WALK.frames(3, 4)),
    "rich.gltf": with_data(*rich_document(WALK.frames(0, 12))),
}


def scenes(file: Path) -> list[Scene]:
    data = file.read_bytes()
    return [read_scene(data, lambda name: read_bytes(file.parent / name), name) for name in animation_names(data)]


def check(file: Path) -> None:
    ours = scenes(file)
    for scene, theirs in zip(ours, three_worlds(file, ours), strict=True):
        assert list(scene.names) == theirs.names
        assert_close(scene.world, theirs.transforms)


@pytest.mark.parametrize("name", MADE)
def test_nodes_of_made_files_are_where_three_has_them(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(MADE[name])
    check(tmp_path / name)


@pytest.mark.parametrize("name", ["robot.glb", "m2m-human-addon-animations.glb"])
def test_nodes_of_other_peoples_files_are_where_three_has_them(name: str) -> None:
    check(shared_rig(name))


def test_joints_of_a_clip_are_where_three_has_them(tmp_path: Path) -> None:
    (tmp_path / "walk.glb").write_bytes(MADE["walk.glb"])
    (theirs,) = three_worlds(tmp_path / "walk.glb", scenes(tmp_path / "walk.glb"))
    clip = read_clip(tmp_path / "walk.glb").clip
    places = theirs.transforms[..., 3][:, [theirs.names.index(name) for name in clip.skeleton.names]]
    assert np.abs(joint_positions(clip) - places).max() < CLOSE * np.ptp(places[0], axis=0).max()
