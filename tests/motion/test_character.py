from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError, RoleError
from motionsplice.motion.formats.character import read_character
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.gltf.reader import animation_names, read_rest, read_scene
from motionsplice.motion.formats.gltf.writer import dump_glb, dump_gltf
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import find_roles
from tests.characters import character_file
from tests.glb_files import edited

WALK, WAVE = make("walk", seconds=1.0), make("walk", "wave", seconds=1.0)
ROLES = find_roles(WALK.skeleton)
SMALLER = WALK.skeleton.scaled(0.8)


def written(tmp_path: Path, data: bytes, clip: Clip = WALK) -> tuple[Clip, bytes]:
    """Returns the clip on the character's skeleton, and the character's file with it."""
    (tmp_path / "hero.glb").write_bytes(data)
    hero = read_character(tmp_path / "hero.glb")
    on_hero = onto_rig(clip, find_roles(clip.skeleton), Rig(hero.skeleton, hero.roles)).clip
    return on_hero, hero.animated(on_hero)


def read_back(tmp_path: Path, data: bytes, **options: Any) -> Clip:
    (tmp_path / "out.glb").write_bytes(data)
    return read_clip(tmp_path / "out.glb", **options).clip


@pytest.mark.parametrize("matrices", [False, True], ids=["parts", "matrices"])
@pytest.mark.parametrize(("scale", "seed"), [(1.0, None), (1.0, 1), (100.0, 2), (0.01, 3)])
def test_the_joints_of_the_character_move_as_the_clip_does(
    tmp_path: Path, scale: float, seed: int | None, matrices: bool
) -> None:
    clip, data = written(tmp_path, character_file(SMALLER, scale=scale, seed=seed, matrices=matrices))
    found = read_back(tmp_path, data)
    assert found.skeleton.names == WALK.skeleton.names
    assert (found.rate, found.frame_count) == (WALK.rate, WALK.frame_count)
    np.testing.assert_allclose(joint_positions(found), joint_positions(clip), atol=1e-5)


@pytest.mark.parametrize("matrices", [False, True], ids=["parts", "matrices"])
@pytest.mark.parametrize(("scale", "seed"), [(1.0, 1), (100.0, 2)])
def test_a_bone_above_the_hips_goes_with_them_over_the_ground(
    tmp_path: Path, scale: float, seed: int, matrices: bool
) -> None:
    data = character_file(SMALLER, scale=scale, seed=seed, matrices=matrices, bound_to_base=True)
    clip, after = written(tmp_path, data)
    np.testing.assert_allclose(joint_positions(read_back(tmp_path, after)), joint_positions(clip), atol=1e-5)
    scene = read_scene(after, lambda name: b"", None)
    base, hips = (scene.world[:, scene.names.index(name), :, 3] for name in ("base", clip.skeleton.names[0]))
    rest = read_rest(after)[0].world[0, scene.names.index("base"), :, 3]
    np.testing.assert_allclose((base - base[0])[:, [0, 2]], (hips - hips[0])[:, [0, 2]], atol=1e-5)
    np.testing.assert_allclose(base[:, 1], rest[1], atol=1e-5)
    assert np.linalg.norm(base[-1] - base[0]) > 0.5


def test_all_else_in_the_file_stays_as_it_is(tmp_path: Path) -> None:
    before = character_file(SMALLER, seed=1)
    _, after = written(tmp_path, before)
    (old, old_data), (new, new_data) = read_document(before), read_document(after)
    assert new_data.startswith(old_data)
    for key, value in old.items():
        if key in ("accessors", "bufferViews"):
            assert new[key][: len(value)] == value
        elif key != "buffers":
            assert new[key] == value, key


def test_animations_of_the_file_stay_and_names_are_unique(tmp_path: Path) -> None:
    _, once = written(tmp_path, character_file(SMALLER, seed=1))
    _, twice = written(tmp_path, once)
    clip, thrice = written(tmp_path, twice, WAVE)
    assert animation_names(thrice) == ["walk", "walk.001", "walk+wave"]
    found = read_back(tmp_path, thrice, animation="walk+wave")
    np.testing.assert_allclose(joint_positions(found), joint_positions(clip), atol=1e-5)


def test_a_character_that_does_not_rest_in_its_bind_pose_is_put_right(tmp_path: Path) -> None:
    """Its nodes rest in another pose, with other lengths, than those in which the mesh was bound."""

    def bent(document: dict[str, Any]) -> None:
        for node in document["nodes"][3:10]:
            node["rotation"] = [0.0, 0.6, 0.0, 0.8]
            node["translation"] = [1.1 * x for x in node["translation"]]

    clip, data = written(tmp_path, edited(character_file(SMALLER, seed=1), bent))
    np.testing.assert_allclose(joint_positions(read_back(tmp_path, data)), joint_positions(clip), atol=1e-5)


def test_a_file_that_cannot_be_written_into_is_refused_with_its_name(tmp_path: Path) -> None:
    def unnamed(document: dict[str, Any]) -> None:
        for number, node in enumerate(document["nodes"]):
            node["name"] = f"bone {number}"

    def beside(document: dict[str, Any]) -> None:
        document["buffers"][0]["uri"] = "hero.bin"

    hero = character_file(SMALLER)
    for data, error, words in (
        (dump_gltf(WALK), FormatError, "this is not a GLB file. Export the character as .glb or .vrm"),
        (edited(hero, beside), FormatError, "its data are not in the file's binary chunk"),
        (edited(hero, unnamed), RoleError, "no joint found for left_hip"),
        (edited(hero, lambda document: document.pop("skins")), FormatError, "no skeleton found"),
        (dump_glb(WALK)[:500], FormatError, "its header says"),
    ):
        (tmp_path / "hero.glb").write_bytes(data)
        with pytest.raises(error, match=f"hero.glb: {words}"):
            read_character(tmp_path / "hero.glb")


HERO = character_file(SMALLER, seed=1)


@given(st.data())
@settings(max_examples=300)
def test_a_damaged_file_is_a_typed_error_or_takes_the_animation(data: st.DataObject) -> None:
    damaged = bytearray(HERO)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, 9000))] = data.draw(st.integers(0, 255))
    with TemporaryDirectory() as folder:
        file = Path(folder) / "hero.glb"
        file.write_bytes(damaged)
        try:
            with np.errstate(all="ignore"):
                hero = read_character(file)
                hero.animated(onto_rig(WALK, ROLES, Rig(hero.skeleton, hero.roles)).clip)
        except MotionError:
            pass


@pytest.mark.parametrize(
    ("key", "value"),
    [("buffers", []), ("animations", [1]), ("animations", 1), ("bufferViews", 3), ("nodes", []), ("buffers", "x")],
)
def test_a_malformed_document_is_a_typed_error(tmp_path: Path, key: str, value: Any) -> None:
    (tmp_path / "hero.glb").write_bytes(edited(HERO, lambda document: document.update({key: value})))
    with pytest.raises(FormatError, match=r"hero\.glb: "):
        read_character(tmp_path / "hero.glb")
