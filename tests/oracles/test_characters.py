from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.formats.character import read_character
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.library import make
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import find_roles
from tests.characters import boxes, character_file, standing
from tests.oracles.node import needs_node, run

CURVE = make("curve", "carry_box", seconds=2.0)
ROLES = find_roles(CURVE.skeleton)


@needs_node
@pytest.mark.parametrize(("scale", "seed"), [(1.0, None), (100.0, 2), (0.01, 3)])
def test_the_mesh_of_a_character_moves_with_its_bones(tmp_path: Path, scale: float, seed: int | None) -> None:
    (tmp_path / "hero.glb").write_bytes(character_file(CURVE.skeleton.scaled(0.8), scale=scale, seed=seed))
    hero = read_character(tmp_path / "hero.glb")
    clip = onto_rig(CURVE, ROLES, Rig(hero.skeleton, hero.roles)).clip
    (tmp_path / "out.glb").write_bytes(hero.animated(clip))
    assert run("validate.mjs", tmp_path / "out.glb") == [[]]
    frames = [0, 31, 77]
    found = run("skinned.mjs", tmp_path / "out.glb", clip.name, *(frame / clip.rate for frame in frames))
    places = standing(clip.skeleton)
    vertices, _, joints, _ = boxes(clip.skeleton, places)
    positions, turns = world_transforms(clip.skeleton, clip.root_positions[frames], clip.rotations[frames])
    expected = positions[:, joints] + quaternion.rotate(turns[:, joints], vertices - places[joints])
    np.testing.assert_allclose(found, expected, atol=1e-5)
