from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats.files import files_behind
from motionsplice.motion.formats.gltf.accessors import read_accessor
from motionsplice.motion.formats.gltf.container import Container, open_container, read_document
from motionsplice.motion.formats.gltf.reader import animation_names, read_scene
from motionsplice.motion.formats.gltf.tracks import Track, key_rate
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.formats.scene import nodes_of
from motionsplice.motion.formats.transforms import rotations_of
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from tests.glb_files import edited

WALK = make("walk", seconds=1.0)


def alone(name: str) -> bytes:
    raise AssertionError(f"{name} was read")


def read(tmp_path: Path, data: bytes, name: str = "walk.glb", **options: Any) -> Clip:
    (tmp_path / name).write_bytes(data)
    return read_clip(tmp_path / name, **options).clip


def test_a_clip_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    clip = read(tmp_path, dump_glb(WALK))
    assert clip.skeleton.names == WALK.skeleton.names
    assert clip.rate == WALK.rate
    assert clip.frame_count == WALK.frame_count
    np.testing.assert_allclose(clip.skeleton.offsets[1:], WALK.skeleton.offsets[1:], atol=1e-6)
    np.testing.assert_allclose(clip.skeleton.end_offsets, WALK.skeleton.end_offsets, atol=1e-6)
    np.testing.assert_allclose(joint_positions(clip), joint_positions(WALK), atol=1e-5)
    assert quaternion.angle(clip.rotations, WALK.rotations).max() < 1e-5


def test_local_axes_scale_and_order_of_nodes_do_not_matter(tmp_path: Path) -> None:
    """The same motion from an exporter that turns bones, scales the armature and lists nodes backwards."""
    draw = np.random.default_rng(0)
    axes = np.asarray(Rotation.random(len(WALK.skeleton.names), random_state=1).as_quat())
    above = np.concatenate([quaternion.IDENTITY[None], axes[WALK.skeleton.parents[1:]]])
    local = quaternion.multiply(quaternion.multiply(quaternion.conjugate(above), WALK.rotations), axes)
    offsets = 100.0 * quaternion.rotate(quaternion.conjugate(above), WALK.skeleton.offsets)
    turned = Clip("walk", WALK.skeleton, WALK.rate, 100.0 * WALK.root_positions, local)
    rest = quaternion.multiply(quaternion.conjugate(above), axes)
    order = draw.permutation(len(WALK.skeleton.names) + len(WALK.skeleton.end_parents) + 1)

    def edit(document: dict[str, Any]) -> None:
        nodes = document["nodes"]
        for joint in range(len(WALK.skeleton.names)):
            nodes[joint]["translation"] = offsets[joint].tolist()
            nodes[joint]["rotation"] = rest[joint].tolist()
        for node in nodes[len(WALK.skeleton.names) :]:
            node["translation"] = [0.0, 0.0, 0.0]
        nodes.append({"name": "Armature", "scale": [0.01, 0.01, 0.01], "children": [0]})
        at = {old: new for new, old in enumerate(order.tolist())}
        document["nodes"] = [nodes[old] for old in order]
        for node in document["nodes"]:
            if "children" in node:
                node["children"] = [at[child] for child in node["children"]]
        document["scenes"][0]["nodes"] = [at[len(nodes) - 1]]
        document["skins"][0]["joints"] = [at[joint] for joint in document["skins"][0]["joints"]]
        del document["skins"][0]["inverseBindMatrices"]
        for channel in document["animations"][0]["channels"]:
            channel["target"]["node"] = at[channel["target"]["node"]]

    clip = read(tmp_path, edited(dump_glb(turned), edit))
    where = [clip.skeleton.names.index(name) for name in WALK.skeleton.names]
    np.testing.assert_allclose(joint_positions(clip)[:, where], joint_positions(WALK), atol=2e-5)
    assert np.abs(clip.skeleton.offsets[where][1:] - WALK.skeleton.offsets[1:]).max() < 2e-5


@pytest.mark.parametrize("interpolation", ["LINEAR", "STEP", "CUBICSPLINE"])
def test_a_track_has_its_keys_at_their_times(interpolation: str) -> None:
    times, values = np.array([0.0, 0.5, 2.0]), np.array([[1.0, 2.0], [3.0, -1.0], [0.0, 5.0]])
    keys = np.zeros((3, 3, 2))
    keys[:, 1] = values
    track = Track(times, keys.reshape(9, 2) if interpolation == "CUBICSPLINE" else values, interpolation, False)
    np.testing.assert_allclose(track.sampled(times), values)
    np.testing.assert_allclose(track.sampled(np.array([-1.0, 9.0])), values[[0, 2]])
    middle = {"LINEAR": [2.0, 0.5], "STEP": [1.0, 2.0], "CUBICSPLINE": [2.0, 0.5]}[interpolation]
    np.testing.assert_allclose(track.sampled(np.array([0.25])), [middle])


@pytest.mark.parametrize("rate", [24.0, 60.0, 120.0])
def test_frames_of_a_long_capture_are_its_keys(rate: float) -> None:
    """After minutes, times in float32 are rounded by a hundredth of a frame."""
    rounded = (np.arange(20_000) / rate).astype(np.float32).astype(np.float64)
    values = np.random.default_rng(0).normal(size=(20_000, 3))
    track = Track(rounded, values, "LINEAR", False)
    assert key_rate([track]) == rate
    np.testing.assert_array_equal(track.sampled(np.arange(20_000) / rate), values)


def test_a_cubic_spline_follows_its_tangents() -> None:
    """Of x^3 between 1 and 3 the curve is x^3 itself."""
    times = np.array([1.0, 3.0])
    values = np.array([[0.0], [1.0], [3.0], [27.0], [27.0], [0.0]])
    inside = np.linspace(1.0, 3.0, 9)
    np.testing.assert_allclose(Track(times, values, "CUBICSPLINE", False).sampled(inside)[:, 0], inside**3)


def container(*views: bytes, **accessor: Any) -> Container:
    """A document with one accessor, over the views one after the other."""
    places = np.cumsum([0, *(len(view) for view in views)]).tolist()
    listed = [{"buffer": 0, "byteOffset": at, "byteLength": len(view)} for at, view in zip(places, views, strict=False)]
    data = b"".join(views)
    return Container({"accessors": [accessor], "bufferViews": listed}, (memoryview(data),), len(data))


def test_normalised_numbers_are_parts_of_1() -> None:
    data = np.array([[-32768, -32767, 0, 32767]], "<i2").tobytes()
    read_as = container(data, bufferView=0, componentType=5122, type="VEC4", count=1, normalized=True)
    np.testing.assert_array_equal(read_accessor(read_as, 0), [[-1.0, -1.0, 0.0, 1.0]])


def test_strided_elements_are_read_between_others() -> None:
    data = np.array([[1.0, 9.0], [2.0, 9.0], [3.0, 9.0]], "<f4").tobytes()
    strided = container(data, bufferView=0, componentType=5126, type="SCALAR", count=3)
    strided.document["bufferViews"][0]["byteStride"] = 8
    np.testing.assert_array_equal(read_accessor(strided, 0), [[1.0], [2.0], [3.0]])


@pytest.mark.parametrize("has_data", [False, True])
def test_sparse_elements_replace_others_or_zeros(has_data: bool) -> None:
    dense, at, new = np.ones((3, 2), "<f4"), np.array([2], "<u2"), np.array([[5.0, 6.0]], "<f4")
    sparse = {"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 2}}
    base = {"bufferView": 0} if has_data else {}
    views = [one.tobytes() for one in (dense, at, new)]
    found = read_accessor(container(*views, componentType=5126, type="VEC2", count=3, sparse=sparse, **base), 0)
    np.testing.assert_array_equal(found, [[has_data, has_data], [has_data, has_data], [5.0, 6.0]])
    views[1] = np.array([3], "<u2").tobytes()
    with pytest.raises(FormatError, match="sparse index 3 is outside 3"):
        read_accessor(container(*views, componentType=5126, type="VEC2", count=3, sparse=sparse, **base), 0)


def test_animations_of_one_name_are_numbered() -> None:
    def edit(document: dict[str, Any]) -> None:
        document["animations"] = [document["animations"][0] | {"name": name} for name in ("a.1", "a", "a", "a.1", "")]

    assert animation_names(edited(dump_glb(WALK), edit)) == ["a.1", "a", "a.001", "a.1.001", "4"]


def test_several_animations_are_chosen_by_name(tmp_path: Path) -> None:
    def twice(document: dict[str, Any]) -> None:
        document["animations"].append(document["animations"][0] | {"name": "again"})

    data = edited(dump_glb(WALK), twice)
    assert animation_names(data) == ["walk", "again"]
    with pytest.raises(FormatError, match=r"2 animations.*--animation.*walk, again"):
        read(tmp_path, data)
    assert read(tmp_path, data, animation="again").name == "walk:again"
    with pytest.raises(FormatError, match=r"no animation 'agian'.*Did you mean 'again'"):
        read(tmp_path, data, animation="agian")


def test_buffers_may_lie_beside_the_file(tmp_path: Path) -> None:
    data = dump_glb(WALK)
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    document["buffers"][0]["uri"] = "walk%20data.bin"
    (tmp_path / "walk data.bin").write_bytes(data[28 + size :])
    assert read(tmp_path, json.dumps(document).encode(), "walk.gltf").frame_count == WALK.frame_count
    (tmp_path / "walk data.bin").write_bytes(data[28 + size : -100])
    with pytest.raises(FormatError, match=r"walk\.gltf.*a buffer should have"):
        read(tmp_path, json.dumps(document).encode(), "walk.gltf")
    document["buffers"][0]["uri"] = "../walk.bin"
    with pytest.raises(FormatError, match="outside its folder"):
        read(tmp_path, json.dumps(document).encode(), "walk.gltf")


WRONG: dict[str, Callable[[dict[str, Any]], None]] = {
    "not a glTF 2.0 file": lambda one: one.__setitem__("asset", {"version": "1.0"}),
    "requires extensions": lambda one: one.__setitem__("extensionsRequired", ["KHR_draco_mesh_compression"]),
    "has no animation": lambda one: one.pop("animations"),
    "form a cycle": lambda one: one["nodes"][-1].__setitem__("children", [0]),
    "child 1 is not a node, or has another parent": lambda one: one["nodes"][-1].__setitem__("children", [1]),
    "do not increase": lambda one: one["accessors"][0].__setitem__("bufferView", 1),
    "malformed": lambda one: one["animations"][0]["channels"][0].pop("target"),
    "do not fit into a view": lambda one: one["accessors"][0].__setitem__("count", 10**9),
    "have no data": lambda one: one["accessors"].__setitem__(
        0, {"componentType": 5126, "type": "VEC3", "count": 10**9}
    ),
    "unknown interpolation": lambda one: one["animations"][0]["samplers"][0].__setitem__("interpolation", "SPLINE"),
    "has 4 numbers, expected 3": lambda one: one["animations"][0]["channels"][1]["target"].__setitem__("path", "scale"),
}


@pytest.mark.parametrize("words", WRONG)
def test_a_wrong_file_is_refused_with_the_reason(tmp_path: Path, words: str) -> None:
    with pytest.raises(FormatError, match=words) as raised:
        read(tmp_path, edited(dump_glb(WALK), WRONG[words]))
    assert "walk.glb" in str(raised.value)


def test_keys_far_apart_take_no_memory(tmp_path: Path) -> None:
    """Two keys a day apart are 5 million frames of each node."""

    def edit(document: dict[str, Any]) -> None:
        document["animations"][0]["samplers"] = [{"input": 0, "output": 1}]
        document["animations"][0]["channels"] = [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]
        document["accessors"] = [
            {"bufferView": 0, "componentType": 5126, "type": "SCALAR", "count": 2},
            {"bufferView": 1, "componentType": 5126, "type": "VEC3", "count": 2},
        ]
        del document["skins"]

    binary = np.array([0.0, 86400.0], "<f4").tobytes()
    data = edited(dump_glb(WALK), edit, binary + read_document(dump_glb(WALK))[1][len(binary) :])
    with pytest.raises(FormatError, match="take too much memory"):
        read(tmp_path, data)


def test_accessors_over_the_same_bytes_take_no_memory(tmp_path: Path) -> None:
    def edit(document: dict[str, Any]) -> None:
        (animation,) = document["animations"]
        sampler, channel = animation["samplers"][1], animation["channels"][1]
        output = document["accessors"][sampler["output"]]
        for _ in range(6000):
            document["accessors"].append(output)
            animation["samplers"].append(sampler | {"output": len(document["accessors"]) - 1})
            animation["channels"].append(channel | {"sampler": len(animation["samplers"]) - 1})

    with pytest.raises(FormatError, match="share their bytes"):
        read(tmp_path, edited(dump_glb(WALK), edit))


def test_buffers_over_the_same_bytes_do_not_raise_the_bound_on_memory(tmp_path: Path) -> None:
    """A buffer's size is what the file may take of memory; here 10,000 share one."""

    def edit(document: dict[str, Any]) -> None:
        document["buffers"] *= 10_000

    _, binary = read_document(edited(dump_glb(WALK), edit))
    assert open_container(edited(dump_glb(WALK), edit), alone).size == len(binary)


@pytest.mark.parametrize("uri", ["walk\0.bin", "x" * 5000, "\ud800"])
def test_names_that_files_cannot_have_are_refused(tmp_path: Path, uri: str) -> None:
    document = read_document(dump_glb(WALK))[0]
    document["buffers"][0]["uri"] = uri
    with pytest.raises(FormatError):
        read(tmp_path, json.dumps(document).encode(), "walk.gltf")
    if len(uri) < 100:
        with pytest.raises(FormatError, match="cannot be a file's name"):
            files_behind(tmp_path / "walk.gltf")


def test_half_characters_in_names_become_question_marks(tmp_path: Path) -> None:
    def edit(document: dict[str, Any]) -> None:
        document["nodes"][3]["name"] = "Spine\ud800"
        document["animations"] = [document["animations"][0] | {"name": name} for name in ("a", "b\udfff")]

    data = edited(dump_glb(WALK), edit)
    assert animation_names(data) == ["a", "b?"]
    assert read(tmp_path, data, animation="b?").skeleton.names[3] == "Spine?"


@given(st.data())
@settings(max_examples=300)
def test_a_damaged_file_is_a_typed_error_or_a_clip(data: st.DataObject) -> None:
    damaged = bytearray(dump_glb(WALK))
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, 9000))] = data.draw(st.integers(0, 255))
    damaged = damaged[: data.draw(st.sampled_from([len(damaged), len(damaged) // 2, 30, 12]))]
    try:
        for name in animation_names(bytes(damaged)):
            with np.errstate(all="ignore"):
                nodes_of(read_scene(bytes(damaged), alone, name))
    except MotionError:
        pass


@given(st.integers(0, 2**32 - 1))
def test_rotations_are_found_in_scaled_axes(seed: int) -> None:
    """Also turns of 180 degrees, which have no w."""
    draw = np.random.default_rng(seed)
    turns = Rotation.from_quat(np.concatenate([draw.normal(size=(20, 4)), np.eye(4), [[1.0, 1.0, 0.0, 0.0]]]))
    transforms = np.zeros((25, 3, 4))
    transforms[..., :3] = turns.as_matrix() * draw.uniform(0.01, 100.0, (25, 1, 3))
    assert quaternion.angle(rotations_of(transforms), turns.as_quat()).max() < 1e-7
