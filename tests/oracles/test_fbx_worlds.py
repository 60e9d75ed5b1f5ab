"""World transforms of FBX files against three.js at key times: between keys, three.js drops the tangents."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motionsplice.motion.formats.fbx.reader import read_scene
from motionsplice.motion.procedural.library import make
from tests.fbx_files import Variant, dump_fbx
from tests.oracles.node import needs_node
from tests.oracles.three import assert_close, shared_rig, three_worlds

pytestmark = needs_node
pytest.importorskip("ufbx")

WALK = make("walk", "wave", seed=1, seconds=1.0)
AXES = np.asarray(Rotation.random(WALK.skeleton.joint_count, random_state=1).as_quat())


def for_three(data: bytes) -> bytes:
    """Returns a text file with what three.js's parser needs: tabs, and the types of properties."""
    lines, depth = list[str](), 0
    for line in (
        data.decode().replace('"PreRotation", "PreRotation", "", "A"', '"PreRotation", "Vector3D", "", ""').split("\n")
    ):
        depth -= line.startswith("}")
        lines.append("\t" * depth + line)
        depth += line.endswith("{")
    return "\n".join(lines).encode()


def check(file: Path) -> float:
    """Returns the part of all transforms that were compared."""
    scene = read_scene(file.read_bytes(), None)
    (theirs,) = three_worlds(file, [scene])
    order = [theirs.names.index(name) for name in scene.names]
    assert_close(scene.world, theirs.transforms[:, order], theirs.keyed[:, order])
    return float(theirs.keyed[:, order].mean())


@pytest.mark.parametrize(
    "variant",
    [
        Variant(),
        Variant(up="z", scale=100.0),
        Variant(unit=1.0, bone_axes=AXES),
        Variant(bone_axes=AXES, scale=3.0, rest=7, bind="skin"),
    ],
)
def test_nodes_of_made_files_are_where_three_has_them(tmp_path: Path, variant: Variant) -> None:
    (tmp_path / "walk.fbx").write_bytes(for_three(dump_fbx([WALK], variant)))
    assert check(tmp_path / "walk.fbx") > 0.9


@pytest.mark.parametrize("name", ["crossarms.fbx", "jog.fbx", "run.fbx", "walk.fbx"])
def test_nodes_of_other_peoples_files_are_where_three_has_them(name: str) -> None:
    assert check(shared_rig(name)) > 0.4
