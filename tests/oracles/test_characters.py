from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.formats.character import read_character
from motionsplice.motion.formats.gltf.vrma import dump_vrma
from motionsplice.motion.formats.gltf.writer import dump_glb, dump_gltf
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.body.common_skeleton import onto_skeleton
from tests.characters import boxes, character_file, standing
from tests.oracles.node import needs_node, run

CURVE = make("curve", "carry_box", seconds=2.0)
ROLES = find_roles(CURVE.skeleton)


@needs_node
@pytest.mark.parametrize(("scale", "seed"), [(1.0, None), (100.0, 2), (0.01, 3)])
def test_the_mesh_of_a_character_moves_with_its_bones(tmp_path: Path, scale: float, seed: int | None) -> None:
    (tmp_path / "hero.glb").write_bytes(character_file(CURVE.skeleton.scaled(0.8), scale=scale, seed=seed))
    hero = read_character(tmp_path / "hero.glb")
    clip = onto_skeleton(CURVE, ROLES, hero.skeleton, hero.roles).clip
    (tmp_path / "out.glb").write_bytes(hero.animated(clip))
    assert run("validate.mjs", tmp_path / "out.glb") == [[]]
    frames = [0, 31, 77]
    found = run("skinned.mjs", tmp_path / "out.glb", clip.name, *(frame / clip.rate for frame in frames))
    places = standing(clip.skeleton)
    vertices, _, joints, _ = boxes(clip.skeleton, places)
    positions, turns = world_transforms(clip.skeleton, clip.root_positions[frames], clip.rotations[frames])
    expected = positions[:, joints] + quaternion.rotate(turns[:, joints], vertices - places[joints])
    np.testing.assert_allclose(found, expected, atol=1e-5)


@needs_node
def test_the_validator_finds_nothing_in_written_files(tmp_path: Path) -> None:
    written = {"x.glb": dump_glb(CURVE), "x.gltf": dump_gltf(CURVE), "x.vrma": dump_vrma(CURVE, ROLES)}
    one = CURVE.frames(0, 1)
    written |= {"one.glb": dump_glb(one), "one.vrma": dump_vrma(one, ROLES)}
    for name, data in written.items():
        (tmp_path / name).write_bytes(data)
    assert run("validate.mjs", *(tmp_path / name for name in written)) == [[]] * len(written)
