from __future__ import annotations

from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.formats.fold import fold
from motionsplice.motion.formats.rest_pose import with_own_bind
from motionsplice.motion.formats.scene import Scene, nodes_of
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.library import make
from motionsplice.motion.skeleton import Skeleton
from tests.motion.test_legs import scene_of

RUN = make("run", seconds=1.0)


def bound_in(scene: Scene, frame: int) -> Scene:
    return replace(scene, bind=scene.world[frame], bound=False)


def skeleton_of(scene: Scene) -> Skeleton:
    return fold(nodes_of(with_own_bind(scene))[0], 0).skeleton


def test_the_frame_at_rest_does_not_matter() -> None:
    scene = scene_of(RUN)
    skeletons = [skeleton_of(bound_in(scene, frame)) for frame in (3, 20)]
    np.testing.assert_allclose(skeletons[0].offsets, skeletons[1].offsets, atol=1e-9)
    assert "rests in a frame of the motion" in with_own_bind(bound_in(scene, 3)).notes[0]


def test_the_motion_stays() -> None:
    scene = scene_of(RUN)
    folded = fold(nodes_of(with_own_bind(bound_in(scene, 7)))[0], 0)
    got, _ = world_transforms(folded.skeleton, folded.root_positions, folded.rotations)
    np.testing.assert_allclose(got, scene.world[..., 3], atol=1e-9)


def test_a_symmetric_pose_at_rest_is_kept_even_if_the_motion_begins_with_it() -> None:
    rotations = RUN.rotations.copy()
    rotations[0] = quaternion.IDENTITY
    scene = scene_of(replace(RUN, rotations=rotations))
    found = with_own_bind(bound_in(scene, 0))
    np.testing.assert_array_equal(found.bind, scene.world[0])
    assert found.notes == ("it states no bind pose; the pose of its nodes at rest is taken",)


def test_a_bind_pose_that_the_file_states_is_kept() -> None:
    scene = replace(scene_of(RUN), bind=scene_of(RUN).world[3])
    assert with_own_bind(scene) is scene
