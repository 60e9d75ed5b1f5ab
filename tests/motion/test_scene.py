"""Scenes that hold several skeletons."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError
from motionsplice.motion.formats.fold import fold
from motionsplice.motion.formats.scene import Scene, nodes_of
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import IDENTITY, Floats
from tests.conftest import CLIPS

WALK, RUN = CLIPS["walk"].frames(0, 20), CLIPS["run"].frames(0, 20)
PROP = 5  # joints of a skeleton that is too small for a body


def scene(clips: Sequence[Clip], prefixes: Sequence[str], small: int = 0) -> Scene:
    """Returns a scene with a node "World", below it each clip's skeleton, and one of `small` joints."""
    names, parents, bind, world = ["World"], [-1], [np.eye(4)[:3]], [np.tile(np.eye(4)[:3], (20, 1, 1))]
    for clip, prefix in zip(clips, prefixes, strict=True):
        skeleton, first = clip.skeleton, len(names)
        names += [prefix + name for name in skeleton.names]
        parents += [0, *(skeleton.parents[1:] + first).tolist()]
        still = np.tile(IDENTITY, (1, skeleton.joint_count, 1))
        bind += list(transforms(*world_transforms(skeleton, np.zeros((1, 3)), still))[0])
        moving = transforms(*world_transforms(skeleton, clip.root_positions, clip.rotations))
        world += list(moving.swapaxes(0, 1))
    for number in range(small):
        names.append(f"chain{number}")
        parents.append(len(names) - 2 if number else 0)
        bind.append(np.eye(4)[:3])
        world.append(np.tile(np.eye(4)[:3], (20, 1, 1)))
    joints = np.array([name != "World" for name in names])
    return Scene(tuple(names), np.array(parents), joints, np.array(bind), np.stack(world, axis=1), 30.0, {})


def transforms(positions: Floats, rotations: Floats) -> Floats:
    matrices = Rotation.from_quat(rotations.reshape(-1, 4)).as_matrix().reshape(*rotations.shape[:-1], 3, 3)
    return np.concatenate([matrices, positions[..., None]], axis=-1)


@pytest.mark.parametrize(
    ("root", "expected"), [(None, WALK), ("A:Hips", WALK), ("B:Hips", RUN), ("B:LeftHand", RUN), ("A:Spine", WALK)]
)
def test_the_skeleton_with_the_given_joint_is_read_and_the_other_is_noted(root: str | None, expected: Clip) -> None:
    nodes, notes = nodes_of(scene([WALK, RUN], ["A:", "B:"], PROP), root)
    mine, other = ("A:Hips", "B:Hips") if expected is WALK else ("B:Hips", "A:Hips")
    np.testing.assert_allclose(fold(nodes, 0).root_positions, expected.root_positions, atol=1e-12)
    assert notes == (
        f"read the skeleton {mine!r}; choose another with --root: {other}",
        "left out, not part of the skeleton: chain0, chain1, chain2, chain3, chain4",
    )


def test_skeletons_of_one_name_are_numbered() -> None:
    nodes, notes = nodes_of(scene([WALK, RUN], ["", ""]), "Hips.001")
    np.testing.assert_allclose(fold(nodes, 0).root_positions, RUN.root_positions, atol=1e-12)
    assert notes == ("read the skeleton 'Hips.001'; choose another with --root: Hips",)


def test_an_unknown_root_is_refused_with_those_that_exist() -> None:
    with pytest.raises(FormatError, match=r"no skeleton has a joint 'World'\. Choose one with --root: A:Hips, B:Hips"):
        nodes_of(scene([WALK, RUN], ["A:", "B:"]), "World")


def test_a_small_skeleton_alone_is_no_other_body() -> None:
    _, notes = nodes_of(scene([WALK], [""], PROP))
    assert notes == ("left out, not part of the skeleton: chain0, chain1, chain2, chain3, chain4",)
