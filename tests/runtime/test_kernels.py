from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motion import quaternion
from motion.kinematics import world_transforms
from motion.pointcloud import horn_rotation
from runtime.bank import Bank
from runtime.evaluator import Evaluator
from runtime.requests import METHODS, POSTURES, TIME_CONSTANT, Requests
from runtime.rotation_kernels import horn, slerp
from tests import naive

seeds = st.integers(0, 2**32 - 1)
STATELESS = sorted(POSTURES.keys() - {"running"})


@given(seeds, st.integers(2, 8), st.floats(0.0, 0.5), st.sampled_from([0.01, 0.3, 10.0]))
def test_horn_is_the_eigenvector_of_its_twin(seed: int, points: int, noise: float, size: float) -> None:
    draw = np.random.default_rng(seed)
    source = size * draw.normal(size=(points, 3))
    known = Rotation.random(random_state=seed).as_quat()
    target = quaternion.rotate(known, source) + noise * size * draw.normal(size=(points, 3))
    values = np.linalg.svd(target.T @ source)[1] * [1.0, 1.0, np.sign(np.linalg.det(target.T @ source))]
    assume(values[1] + values[2] > 1e-3 * values[0])  # else no rotation is best
    found = np.empty(4)
    horn(target.T @ source, found)
    assert quaternion.angle(found, horn_rotation(target, source)) < 1e-6
    assert np.linalg.norm(found) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "correlation",
    [
        np.zeros((3, 3)),
        np.outer([1.0, 2.0, 3.0], [2.0, 1.0, 0.0]),
        1e-30 * np.outer([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
    ],
)
def test_horn_of_clouds_without_a_best_rotation_is_the_identity(correlation: quaternion.Floats) -> None:
    found = np.empty(4)
    horn(correlation, found)
    np.testing.assert_array_equal(found, quaternion.IDENTITY)


@given(seeds, st.floats(0.0, np.pi / 3), st.floats(0.0, 1.0))
def test_series_slerp_is_slerp(seed: int, radians: float, t: float) -> None:
    a = Rotation.random(random_state=seed).as_quat()
    axis = np.random.default_rng(seed).normal(size=3)
    b = quaternion.multiply(a, quaternion.about(axis / np.linalg.norm(axis), radians))
    found = np.empty(4)
    slerp(a, b, t, found)
    assert quaternion.angle(found, quaternion.slerp(a, b, t)) < 2e-6


@pytest.mark.parametrize(("degrees", "bound"), [(60.0, 1e-7), (90.0, 1e-5), (150.0, 1e-3), (180.0, 0.0051)])
def test_series_slerp_is_off_by_no_more_than_it_says(degrees: float, bound: float) -> None:
    axis, found = [1.0, 0.0, 0.0], np.empty(4)
    for t in np.linspace(0.0, 1.0, 201):
        slerp(quaternion.IDENTITY, quaternion.about(axis, np.radians(degrees)), t, found)
        assert quaternion.angle(found, quaternion.about(axis, t * np.radians(degrees))) < bound


@given(st.data())
@settings(max_examples=150)
def test_poses_are_those_of_the_twin(bank: Bank, data: st.DataObject) -> None:
    locomotion, action = (data.draw(st.sampled_from(bank.clips)) for _ in range(2))
    time = data.draw(st.floats(0.0, locomotion.duration))
    start = data.draw(st.sampled_from([0.0, 0.3, 1.7]))
    method, posture = data.draw(st.sampled_from(sorted(METHODS))), data.draw(st.sampled_from(STATELESS))
    poses = Evaluator(bank).pose(locomotion.name, time, action.name, start=start, method=method, posture=posture)  # type: ignore[arg-type]
    root, rotations = naive.pose(bank, locomotion.name, time, action.name, start, method, posture)
    np.testing.assert_allclose(poses.root_positions[0], root, atol=1e-5)
    assert quaternion.angle(poses.rotations[0], rotations).max() < 5e-5


@given(st.sampled_from(["walk", "run", "turn_180"]), st.sampled_from(["carry_box", "wave"]))
@settings(max_examples=6)
def test_a_running_posture_is_that_of_its_twin(bank: Bank, locomotion: str, action: str) -> None:
    evaluator = Evaluator(bank)
    found = evaluator.clip(locomotion, action, posture="running")
    twin = naive.followed(bank, evaluator.clip(locomotion, action, posture="off"), locomotion, action, TIME_CONSTANT)
    assert quaternion.angle(found.rotations, twin.rotations).max() < 5e-5


def test_world_positions_are_forward_kinematics(bank: Bank) -> None:
    evaluator = Evaluator(bank)
    poses = evaluator.sequence("walk", evaluator.frame_times("walk"), "wave")
    positions = np.empty((len(poses.rotations), bank.skeleton.joint_count, 3), np.float32)
    evaluator.world_positions(poses, positions)
    expected = world_transforms(bank.skeleton, poses.root_positions, poses.rotations)[0]
    np.testing.assert_allclose(positions, expected, atol=1e-5)


def test_a_batch_is_its_characters_one_by_one(bank: Bank) -> None:
    evaluator, draw, count = Evaluator(bank), np.random.default_rng(3), 200
    requests, poses = Requests.empty(count), evaluator.poses(count)
    requests.locomotion[:], requests.action[:] = draw.integers(0, len(bank.clips), (2, count))
    requests.time[:] = draw.random(count) * [bank.clips[one].duration for one in requests.locomotion]
    requests.method[:], requests.posture[:] = draw.integers(0, 3, (2, count))
    evaluator.evaluate(requests, poses)
    single = evaluator.poses(1)
    for character in range(count):
        one = Requests(*(getattr(requests, name)[character : character + 1] for name in Requests.__annotations__))
        evaluator.evaluate(one, single)
        np.testing.assert_array_equal(single.rotations[0], poses.rotations[character])
        np.testing.assert_array_equal(single.root_positions[0], poses.root_positions[character])
