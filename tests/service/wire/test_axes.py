from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion.axes import AXES, Axes, AxesName
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from motionsplice.service.wire.encode_kernels import convert, shorten
from motionsplice.service.wire.encoding import INT16_ERROR, Encoding

seeds = st.integers(0, 2**32 - 1)
every = pytest.mark.parametrize("axes", AXES.values(), ids=AXES.keys())


def matrix(axes: Axes) -> Floats:
    """Returns the change of axes as a matrix, without the unit."""
    found = np.zeros((3, 3))
    for row, (column, sign) in enumerate(zip(axes.order, axes.signs, strict=True)):
        found[row, column] = sign
    return found


def test_all_axes_have_a_name_in_the_schema() -> None:
    assert get_args(AxesName) == tuple(AXES)


@every
@given(seed=seeds)
def test_a_rotation_has_the_same_effect_in_any_axes(axes: Axes, seed: int) -> None:
    draw = np.random.default_rng(seed)
    rotation, point, change = Rotation.random(random_state=draw), draw.normal(size=3), matrix(axes)
    ours = rotation.as_quat()
    theirs = np.array([*(ours[list(axes.order)] * axes.turns), ours[3]])
    turned = Rotation.from_quat(theirs).apply(change @ point)
    np.testing.assert_allclose(turned, change @ rotation.apply(point), atol=1e-12)


@pytest.mark.parametrize(
    ("name", "up", "forward", "left", "left_handed", "metre"),
    [
        ("gltf", [0, 1, 0], [0, 0, 1], [1, 0, 0], False, 1.0),
        ("godot", [0, 1, 0], [0, 0, 1], [1, 0, 0], False, 1.0),
        ("unity", [0, 1, 0], [0, 0, 1], [-1, 0, 0], True, 1.0),
        ("unreal", [0, 0, 1], [1, 0, 0], [0, -1, 0], True, 100.0),
        ("blender", [0, 0, 1], [0, -1, 0], [1, 0, 0], False, 1.0),
    ],
)
def test_axes_are_those_of_the_engines(
    name: str, up: list[int], forward: list[int], left: list[int], left_handed: bool, metre: float
) -> None:
    axes = AXES[name]
    ours = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # a character's up, forward and left
    np.testing.assert_array_equal(axes.positions(ours), metre * np.array([up, forward, left]))
    assert (np.linalg.det(matrix(axes)) < 0) == left_handed


@every
def test_joints_placed_by_rotations_and_offsets_match_the_world_positions(bank: Bank, axes: Axes) -> None:
    evaluator = Evaluator(bank)
    poses = evaluator.sequence(Splice("run", "wave"), [0.0, 0.7, 1.9])
    sent = Encoding(axes, "float32", "both").arrays(evaluator, poses)
    offsets = axes.positions(bank.skeleton.offsets)
    for root, rotations, positions in zip(*sent.values(), strict=True):
        world, turns = [root.astype(float)], [Rotation.from_quat(rotations[0])]
        for joint in range(1, bank.skeleton.joint_count):
            parent = int(bank.skeleton.parents[joint])
            world.append(world[parent] + turns[parent].apply(offsets[joint]))
            turns.append(turns[parent] * Rotation.from_quat(rotations[joint]))
        np.testing.assert_allclose(np.array(world), positions, atol=2e-5 * axes.scale)


@given(seed=seeds)
def test_the_error_of_normalised_integers_is_within_the_stated_limit(seed: int) -> None:
    rotations = Rotation.random(200, random_state=seed).as_quat().astype(np.float32)
    short = np.empty(rotations.shape, np.int16)
    shorten(rotations.reshape(-1), short.reshape(-1))
    back = Rotation.from_quat(np.maximum(short / 32767.0, -1.0))
    assert np.degrees((back * Rotation.from_quat(rotations).inv()).magnitude()).max() < INT16_ERROR


def test_normalised_integers_follow_gltf() -> None:
    numbers = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 1.0001, -1.0001], np.float32)
    short = np.empty(7, np.int16)
    shorten(numbers, short)
    assert short.tolist() == [0, 32767, -32767, 16384, -16383, 32767, -32767]


@given(seed=seeds, rows=st.integers(0, 20), width=st.sampled_from([3, 4]))
def test_the_conversion_kernel_matches_numpy(seed: int, rows: int, width: int) -> None:
    draw = np.random.default_rng(seed)
    ours, order = draw.normal(size=(rows, width)).astype(np.float32), draw.permutation(width)
    factors, out = draw.normal(size=width).astype(np.float32), np.empty((rows, width), np.float32)
    convert(ours, order, factors, out)
    np.testing.assert_array_equal(out, ours[:, order] * factors)
