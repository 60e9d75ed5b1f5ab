from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels import lookup as lookup_kernels
from motionsplice.runtime.kernels.posture import LEAST_GAP
from motionsplice.runtime.kernels.rotations import horn, sample
from motionsplice.runtime.mirrored import MIRRORED
from motionsplice.runtime.requests import METHODS, POSTURES, TIME_CONSTANT, Memory, Requests
from motionsplice.runtime.simd.width import LANES
from motionsplice.runtime.splice import Splice
from tests import naive, random_bank

seeds = st.integers(0, 2**32 - 1)
STATELESS = sorted(POSTURES.keys() - {"running"})


def horn_of(pairs: Sequence[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """Returns the kernel's rotations [n, 4] that align each pair's second cloud to its first, and their gaps [n]."""
    block = np.zeros((arrays.BLOCK_ROWS, arrays.BLOCK))
    for lane, (target, source) in enumerate(pairs):
        block[arrays.CORRELATION : arrays.BOUND, lane] = (target.T @ source).ravel()
        block[arrays.BOUND, lane] = 0.5 * (np.sum(target**2) + np.sum(source**2)) * (1.0 + 1e-12)
    flat = block.ravel()
    horn(flat)
    count = len(pairs)
    return block[arrays.ALIGNED : arrays.ALIGNED + 4, :count].T, block[arrays.GAP, :count]


@given(seeds, st.integers(2, 8), st.floats(0.0, 0.5), st.sampled_from([0.01, 0.3, 10.0]))
def test_horn_agrees_with_its_twin(seed: int, points: int, noise: float, size: float) -> None:
    draw, pairs = np.random.default_rng(seed), []
    for _ in range(arrays.BLOCK):
        source = size * draw.normal(size=(points, 3))
        target = quaternion.rotate(Rotation.random(random_state=draw).as_quat(), source)
        pairs.append((target + noise * size * draw.normal(size=(points, 3)), source))
    found, gaps = horn_of(pairs)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0)
    for pair, rotation, gap in zip(pairs, found, gaps, strict=True):
        assert 0.4 * naive.gap(*pair) <= gap <= 1.5 * naive.gap(*pair) + 1e-6
        if gap >= LEAST_GAP:
            assert quaternion.angle(rotation, horn_rotation(*pair)) < 1e-6


@given(seeds, st.floats(-7.0, -0.5))
def test_horn_of_a_nearly_straight_torso_is_exact_or_has_no_gap(seed: int, magnitude: float) -> None:
    draw = np.random.default_rng(seed)
    torso = np.array([[0.0, y, 0.0] for y in (0.1, 0.2, 0.33, 0.45)] + [[0.17, 0.4, 0.0], [-0.17, 0.4, 0.0]])
    width = 10.0**magnitude
    pairs = []
    for _ in range(arrays.BLOCK):
        target, source = (torso * [width, 1.0, 1.0] + 0.1 * width * draw.normal(size=(6, 3)) for _ in range(2))
        pairs.append((quaternion.rotate(Rotation.random(random_state=draw).as_quat(), target), source))
    for pair, rotation, gap in zip(pairs, *horn_of(pairs), strict=True):
        if gap >= LEAST_GAP:
            assert quaternion.angle(rotation, horn_rotation(*pair)) < 1e-5
        else:
            assert naive.gap(*pair) < 3.0 * LEAST_GAP


@given(
    seeds,
    st.sampled_from(["any", "far apart", "flat", "pairs alike", "all alike", "straight"]),
    st.floats(-8.0, 8.0),
    st.floats(-3.0, 3.0),
)
def test_horn_is_exact_or_has_no_gap(seed: int, kind: str, scale: float, slack: float) -> None:
    draw, pairs, truths = np.random.default_rng(seed), [], []
    for _ in range(arrays.BLOCK):
        values = singular_values(kind, draw)
        turned, kept = Rotation.random(random_state=draw), Rotation.random(random_state=draw)
        clouds = [one.as_matrix() * np.sqrt(np.abs(values)) for one in (turned, kept)]
        clouds[0][:, 2] *= np.sign(values[2])
        pairs.append((10.0 ** (scale + slack) * clouds[0].T, 10.0 ** (scale - slack) * clouds[1].T))
        truths.append(((turned * kept.inv()).as_quat(), values))
    for pair, (truth, values), rotation, gap in zip(pairs, truths, *horn_of(pairs), strict=True):
        if gap >= LEAST_GAP:
            assert quaternion.angle(rotation, truth) < (1e-5 if values[2] < 0.0 else 1e-8)
        elif values[2] >= -0.5 * values[1]:
            assert naive.gap(*pair) < 3.0 * LEAST_GAP


def singular_values(kind: str, draw: np.random.Generator) -> Floats:
    """Returns singular values of a correlation, in falling order; the last has the sign of the determinant."""
    near = 10.0 ** draw.uniform(-8.0, 0.0, 3)
    values = {
        "any": draw.random(3),
        "far apart": near,
        "flat": draw.random(3) * [1.0, 1.0, 0.0],
        "pairs alike": np.repeat(draw.random(), 3) * [1.0 / draw.random(), 1.0, 1.0 - near[0]],
        "all alike": 1.0 - 0.1 * near,
        "straight": near * [0.0, 1.0, 1.0] + [1.0, 0.0, 0.0],
    }[kind]
    return np.sort(values)[::-1] * [1.0, 1.0, draw.choice([-1.0, 1.0])]


@pytest.mark.parametrize(
    "correlation",
    [
        np.zeros((3, 3)),
        np.outer([1.0, 2.0, 3.0], [2.0, 1.0, 0.0]),
        1e-30 * np.outer([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
    ],
)
def test_clouds_without_a_best_rotation_have_no_gap(correlation: Floats) -> None:
    block = np.zeros((arrays.BLOCK_ROWS, arrays.BLOCK))
    block[arrays.CORRELATION : arrays.BOUND] = correlation.reshape(9, 1)
    block[arrays.BOUND] = np.linalg.norm(correlation)
    flat = block.ravel()
    horn(flat)
    assert block[arrays.GAP].max() < 1e-6


def sampled(a: Floats, b: Floats, t: float) -> Floats:
    """Returns the kernel's interpolation between two keys; checks that it is the same in all lanes of a row."""
    rows, out = np.zeros((2, 4 * LANES), np.float32), np.empty(4 * LANES, np.float32)
    rows[0], rows[1] = np.repeat(a, LANES), np.repeat(b, LANES)
    sample(rows, np.uint64(0), np.uint64(0), np.uint64(LANES), np.float32(t), out, np.uint64(0))
    lanes = out.reshape(LANES, 4)
    np.testing.assert_array_equal(lanes, np.tile(lanes[0], (LANES, 1)))
    return lanes[0].astype(np.float64)


@given(seeds, st.floats(0.0, np.pi / 3), st.floats(0.0, 1.0))
def test_series_slerp_is_slerp(seed: int, radians: float, t: float) -> None:
    a = Rotation.random(random_state=seed).as_quat()
    axis = np.random.default_rng(seed).normal(size=3)
    b = quaternion.multiply(a, quaternion.about(axis / np.linalg.norm(axis), radians))
    found = sampled(a, b, t)
    assert quaternion.angle(found, quaternion.slerp(a, b, t)) < 2e-6
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("degrees", "bound"), [(60.0, 1e-6), (90.0, 1e-5), (150.0, 1e-3), (180.0, 0.0051)])
def test_the_error_of_series_slerp_is_within_its_documented_bound(degrees: float, bound: float) -> None:
    axis = [1.0, 0.0, 0.0]
    for t in np.linspace(0.0, 1.0, 201):
        found = sampled(quaternion.IDENTITY, quaternion.about(axis, np.radians(degrees)), t)
        assert quaternion.angle(found, quaternion.about(axis, t * np.radians(degrees))) < bound
        assert np.linalg.norm(found) == pytest.approx(1.0, abs=2e-4)


@given(st.data())
@settings(max_examples=150)
def test_poses_agree_with_the_twin(bank: Bank, data: st.DataObject) -> None:
    locomotion, action = (data.draw(st.sampled_from(bank.numbered)) for _ in range(2))
    time = data.draw(st.floats(0.0, locomotion.duration))
    start = data.draw(st.sampled_from([0.0, 0.3, 1.7]))
    method, posture = data.draw(st.sampled_from(sorted(METHODS))), data.draw(st.sampled_from(STATELESS))
    cycles, requests, poses = data.draw(st.integers(-2, 5)), Requests.empty(1), Evaluator(bank).poses(1)
    clips = bank.number(locomotion.name), bank.number(action.name)
    requests.records[0] = (*clips, time, start, cycles, METHODS[method], POSTURES[posture], 0)
    Evaluator(bank).evaluate(requests, poses)
    root, rotations = naive.pose(bank, locomotion.name, time, action.name, start, method, posture, cycles)
    np.testing.assert_allclose(poses.root_positions[0], root, atol=1e-5)
    assert quaternion.angle(poses.rotations[0], rotations).max() < 5e-5


@given(seeds, st.integers(3, 60), st.integers(3, 20), st.sampled_from(random_bank.CLOUDS))
@settings(max_examples=60)
def test_random_banks_are_evaluated_as_by_the_twin(seed: int, joints: int, points: int, clouds: str) -> None:
    bank, draw = random_bank.random_bank(seed, joints, 3, points, clouds), np.random.default_rng(seed)
    evaluator = Evaluator(bank)
    for _ in range(8):
        locomotion, action = (bank.numbered[one] for one in draw.integers(0, 6, 2))
        time, start = draw.random() * locomotion.duration, draw.random() * action.duration * draw.integers(0, 2)
        method, posture = draw.choice(sorted(METHODS)), draw.choice(STATELESS)
        upper = locomotion if method == "none" else action
        fits = upper.name.removesuffix(MIRRORED) in {one.body for one in bank.hands}
        hands = "hands" if fits and draw.random() < 0.7 else None
        requests, poses = Requests.empty(1), evaluator.poses(1)
        clips, hands_number = (bank.number(locomotion.name), bank.number(action.name)), 0 if hands is None else 1
        requests.records[0] = (*clips, time, start, 0, METHODS[method], POSTURES[posture], hands_number)
        evaluator.evaluate(requests, poses)
        root, rotations = naive.pose(bank, locomotion.name, time, action.name, start, method, posture, hands=hands)
        np.testing.assert_allclose(poses.root_positions[0], root, atol=1e-5)
        assert quaternion.angle(poses.rotations[0], rotations).max() < 1e-4
        np.testing.assert_allclose(np.linalg.norm(poses.rotations[0], axis=-1), 1.0, atol=1e-5)


def test_an_unclear_alignment_is_replaced_by_the_last_clear_one() -> None:
    clear, unclear = (random_bank.random_bank(5, 9, 1, 6, clouds) for clouds in ("torso", "line"))
    memory, pelvis = Memory.begin(1, rate=30.0), clear.roles.pelvis
    splice = Splice("clip 0", "clip 0", posture="off")
    memory.turns[:] = held = quaternion.about([0.0, 0.0, 1.0], 0.3)
    turned = Evaluator(unclear).sequence(splice, [0.0], memory=memory).rotations[0, pelvis]
    own = unclear.motion("clip 0").rotations[0, pelvis]
    assert quaternion.angle(turned, quaternion.multiply(own, held)) < 1e-6
    np.testing.assert_array_equal(memory.turns[0], held)
    alone = Evaluator(unclear).sequence(splice, [0.0]).rotations[0, pelvis]
    assert quaternion.angle(alone, own) < 1e-6
    Evaluator(clear).sequence(splice, [0.0], memory=memory)
    assert quaternion.angle(memory.turns[0], quaternion.IDENTITY) < 1e-5  # locomotion and action are the same clip


@given(seeds, st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e30, 0.0]))
@settings(max_examples=40)
def test_no_damaged_number_makes_kernels_read_outside_the_clip(seed: int, value: float) -> None:
    """In plain Python, a row outside a table raises. With any damage, action frames must lie within the clip."""
    bank, draw = random_bank.random_bank(seed, 5, 2, 4, "torso"), np.random.default_rng(seed)
    evaluator, (locomotion, action) = Evaluator(bank), bank.clips
    with np.errstate(all="ignore"):
        for name in ("phase_of_frame", "frame_of_phase", "lower", "upper"):
            flat = bank.tables[name].reshape(-1)
            flat[draw.integers(0, flat.size, flat.size // 4)] = value
        for time in np.linspace(0.0, locomotion.duration, 7):
            evaluator.pose(Splice(locomotion.name, action.name, start=action.duration / 2.0), time)
        frames = evaluator.action_frames(Splice(locomotion.name, action.name), np.linspace(0.0, locomotion.duration, 7))
    rows = [lookup_kernels.locate(frame, action.first_row, action.row_count) for frame in frames]
    assert all(action.first_row <= row < action.first_row + action.row_count - 1 for row, _ in rows)


@given(st.sampled_from(["walk", "run~mirror", "turn_180"]), st.sampled_from(["carry_box", "wave", "wave~mirror"]))
@settings(max_examples=6)
def test_a_running_posture_agrees_with_its_twin(bank: Bank, locomotion: str, action: str) -> None:
    evaluator = Evaluator(bank)
    found = evaluator.clip(Splice(locomotion, action, posture="running"))
    twin = naive.followed(
        bank, evaluator.clip(Splice(locomotion, action, posture="off")), locomotion, action, TIME_CONSTANT
    )
    assert quaternion.angle(found.rotations, twin.rotations).max() < 5e-5


def test_world_positions_are_forward_kinematics(bank: Bank) -> None:
    evaluator = Evaluator(bank)
    poses = evaluator.sequence(Splice("walk", "wave"), evaluator.frame_times("walk"))
    positions = np.empty((len(poses.rotations), bank.skeleton.joint_count, 3), np.float32)
    evaluator.world_positions(poses, positions)
    expected = world_transforms(bank.skeleton, poses.root_positions, poses.rotations)[0]
    np.testing.assert_allclose(positions, expected, atol=1e-5)


@pytest.mark.parametrize("count", [1, 31, 33, 64, 200])
def test_poses_do_not_depend_on_the_number_of_threads(bank: Bank, count: int) -> None:
    draw, requests, memory = np.random.default_rng(count), Requests.empty(count), Memory.begin(count, rate=60.0)
    requests.locomotion[:], requests.action[:] = draw.integers(0, len(bank.numbered), (2, count))
    requests.posture[:] = draw.integers(0, len(POSTURES), count)
    results = []
    for threads in (1, 2):
        evaluator, own = Evaluator(bank, threads=threads), Memory(memory.state.copy(), memory.share)
        poses = evaluator.poses(count)
        for frame in range(3):
            requests.time[:] = frame / 60.0
            evaluator.evaluate(requests, poses, own)
        results.append((poses.rotations, poses.root_positions, own.state))
    for one, other in zip(*results, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_batch_gives_the_same_poses_as_single_requests(bank: Bank) -> None:
    evaluator, draw, count = Evaluator(bank), np.random.default_rng(3), 200
    requests, poses = Requests.empty(count), evaluator.poses(count)
    requests.locomotion[:], requests.action[:] = draw.integers(0, len(bank.numbered), (2, count))
    requests.time[:] = draw.random(count) * [bank.numbered[one].duration for one in requests.locomotion]
    requests.method[:] = draw.integers(0, len(METHODS), count)
    requests.posture[:] = draw.choice([POSTURES[posture] for posture in STATELESS], count)
    evaluator.evaluate(requests, poses)
    single = evaluator.poses(1)
    for character in range(count):
        evaluator.evaluate(Requests(requests.records[character : character + 1]), single)
        np.testing.assert_array_equal(single.rotations[0], poses.rotations[character])
        np.testing.assert_array_equal(single.root_positions[0], poses.root_positions[character])
