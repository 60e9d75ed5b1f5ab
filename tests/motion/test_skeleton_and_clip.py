from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.evenness import unevenness
from motionsplice.motion.kinematics import end_positions, joint_positions, world_transforms
from motionsplice.motion.skeleton import Skeleton, shared


def arm(count: int = 3) -> Skeleton:
    """Joints in a row along x, one metre apart, with one end site."""
    offsets = np.tile([1.0, 0.0, 0.0], (count, 1))
    names = tuple(f"joint{number}" for number in range(count))
    return Skeleton(names, np.arange(count) - 1, offsets, np.array([count - 1]), np.array([[1.0, 0.0, 0.0]]))


def turning(frames: int = 5, rate: float = 10.0) -> Clip:
    rotations = np.tile(quaternion.IDENTITY, (frames, 3, 1))
    rotations[:, 1] = quaternion.about([0.0, 0.0, 1.0], np.linspace(0.0, 2.0, frames))
    return Clip("arm", arm(), rate, np.linspace([0.0, 0.0, 0.0], [4.0, 0.0, 0.0], frames), rotations)


def test_kinematics_of_a_bent_arm() -> None:
    skeleton, quarter = arm(), quaternion.about([0.0, 0.0, 1.0], np.pi / 2)
    rotations = np.stack([quaternion.IDENTITY, quarter, quarter])[None]
    positions, world = world_transforms(skeleton, [[0.0, 2.0, 0.0]], rotations)
    np.testing.assert_allclose(positions[0], [[0, 2, 0], [1, 2, 0], [1, 3, 0]], atol=1e-12)
    np.testing.assert_allclose(end_positions(skeleton, positions, world)[0], [[0, 3, 0]], atol=1e-12)


def test_kinematics_keep_bone_lengths() -> None:
    rotations = Rotation.random(30, random_state=1).as_quat().reshape(10, 3, 4)
    positions = world_transforms(arm(), np.zeros((10, 3)), rotations)[0]
    np.testing.assert_allclose(np.linalg.norm(np.diff(positions, axis=1), axis=-1), 1.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"names": ("a", "b", "a")}, "same name"),
        ({"names": ("a", "b")}, "parents"),
        ({"parents": np.array([-1, 2, 0])}, "parent before child"),
        ({"parents": np.array([-1, -1, 0])}, "single root"),
        ({"offsets": np.full((3, 3), np.nan)}, "finite"),
        ({"end_offsets": np.zeros((2, 3))}, "end site"),
        ({"end_parents": np.array([3])}, "parent of an end site does not exist"),
    ],
)
def test_a_broken_skeleton_is_refused(change: dict[str, NDArray[np.float64]], words: str) -> None:
    with pytest.raises(ClipError, match=words):
        replace(arm(), **change)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rate": 0.0}, "frames per second"),
        ({"root_positions": np.zeros((0, 3))}, "no frames"),
        ({"root_positions": np.zeros((4, 3))}, "rotations"),
        ({"root_positions": np.full((5, 3), np.inf)}, "frame 0"),
        ({"root_positions": np.full((5, 3), 1e300)}, "farther than"),
        ({"rotations": np.zeros((5, 3, 4))}, "unit quaternion"),
    ],
)
def test_a_broken_clip_is_refused(change: dict[str, NDArray[np.float64]], words: str) -> None:
    with pytest.raises(ClipError, match=words):
        replace(turning(), **change)  # type: ignore[arg-type]


def test_an_unknown_joint_is_answered_with_similar_names() -> None:
    with pytest.raises(ClipError, match="joint1"):
        arm().index("jont1")


def test_sampling_interpolates_between_frames_and_holds_the_ends() -> None:
    clip = turning()
    positions, rotations = clip.sampled([0.0, 1.5, 4.0, -3.0, 9.0])
    np.testing.assert_allclose(positions[:, 0], [0.0, 1.5, 4.0, 0.0, 4.0])
    angles = quaternion.angle(rotations[:, 1], quaternion.IDENTITY)
    np.testing.assert_allclose(angles, [0.0, 0.75, 2.0, 0.0, 2.0], atol=1e-9)


def test_resampling_keeps_the_motion() -> None:
    clip = turning().resampled(20.0)
    assert clip.frame_count == 9
    np.testing.assert_allclose(clip.root_positions[:, 0], np.linspace(0.0, 4.0, 9))
    np.testing.assert_allclose(joint_positions(clip)[::2], joint_positions(turning()), atol=1e-9)


def test_subtree_and_chain() -> None:
    skeleton = arm()
    assert skeleton.subtree(1) == [1, 2]
    assert skeleton.chain(2) == [2, 1, 0]
    assert skeleton.children == ((1,), (2,), ())


def test_a_part_of_a_clip_shares_its_memory_and_is_not_checked_again() -> None:
    clip = turning()
    part = clip.frames(1, 4)
    assert np.shares_memory(part.rotations, clip.rotations)
    clip.rotations[2] = 9.0  # nobody does this; it shows that only the constructor looks at rotations
    assert clip.frames(1, 4).frame_count == 3
    with pytest.raises(ClipError, match="unit quaternion"):
        replace(clip, name="checked")
    with pytest.raises(ClipError, match="no frames"):
        clip.frames(3, 3)


def test_frames_that_follow_are_checked_and_lie_in_one_hemisphere() -> None:
    clip = turning()
    more = clip.followed_by(clip.root_positions[-1:] + 1.0, -clip.rotations[-1:])
    assert more.frame_count == 6
    np.testing.assert_array_equal(more.rotations, np.concatenate([clip.rotations, clip.rotations[-1:]]))
    np.testing.assert_array_equal(more.root_positions[-1], clip.root_positions[-1] + 1.0)
    with pytest.raises(ClipError, match="unit quaternion"):
        clip.followed_by(clip.root_positions[:2], np.zeros((2, 3, 4)))
    with pytest.raises(ClipError, match="farther than"):
        clip.followed_by(np.full((1, 3), 1e300), clip.rotations[:1])


def test_skeletons_are_equal_by_their_contents_and_shared() -> None:
    skeleton = arm()
    same, other = replace(skeleton, offsets=skeleton.offsets.copy()), skeleton.scaled(2.0)
    assert same == skeleton
    assert hash(same) == hash(skeleton)
    assert other != skeleton
    assert shared(same) is shared(skeleton)
    assert shared(other) == other


@given(st.integers(0, 2**32 - 1), st.sampled_from(["", "long", "turned", "nan"]))
def test_unevenness_is_that_of_the_slow_twin(seed: int, flaw: str) -> None:
    rng = np.random.default_rng(seed)
    rotations = quaternion.normalise(rng.normal(size=(5, 3, 4)) + 3.0)
    at = tuple(rng.integers(0, (5, 3)))
    rotations[at] *= {"": 1.0, "long": 1.01, "turned": -1.0, "nan": np.nan}[flaw]
    error, least = unevenness(rotations)
    errors = np.abs(np.linalg.norm(rotations, axis=-1) - 1.0)
    products = np.sum(rotations[1:] * rotations[:-1], axis=-1)
    assert error == (np.inf if flaw == "nan" else pytest.approx(errors.max(), abs=1e-15))
    assert least == pytest.approx(np.nanmin(products))
