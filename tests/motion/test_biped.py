from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.fbx.biped import with_legs_on_the_pelvis
from motionsplice.motion.formats.scene import Scene
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.library import make

WALK = make("walk", seconds=1.0)
NAMES = WALK.skeleton.names
HIPS = [NAMES.index("LeftUpLeg"), NAMES.index("RightUpLeg")]
SPINE = NAMES.index("Spine")


def scene_of(clip: Clip) -> Scene:
    positions, turns = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    axes = Rotation.from_quat(turns.reshape(-1, 4)).as_matrix().reshape(*turns.shape[:2], 3, 3)
    world = np.concatenate([axes, positions[..., None]], axis=-1)
    joints = np.ones(len(NAMES), np.bool_)
    return Scene(NAMES, clip.skeleton.parents, joints, world[0], world, clip.rate, {})


def hung_on_the_spine(scene: Scene) -> Scene:
    parents = scene.parents.copy()
    parents[HIPS] = SPINE
    return replace(scene, parents=parents)


def test_legs_that_follow_the_pelvis_hang_on_it() -> None:
    scene = scene_of(WALK)
    found = with_legs_on_the_pelvis(hung_on_the_spine(scene))
    np.testing.assert_array_equal(found.parents, scene.parents)
    assert found.notes == ("the legs hang on 'Hips', which they follow, not on 'Spine'",)


def test_legs_that_follow_the_spine_stay_there() -> None:
    assert np.ptp(WALK.rotations[:, SPINE], axis=0).max() > 0.01
    parents = WALK.skeleton.parents.copy()
    parents[HIPS] = SPINE
    scene = scene_of(replace(WALK, skeleton=replace(WALK.skeleton, parents=parents)))
    assert with_legs_on_the_pelvis(scene) is scene


def test_other_rigs_stay_as_they_are() -> None:
    scene = scene_of(WALK)
    assert with_legs_on_the_pelvis(scene) is scene
    nameless = replace(hung_on_the_spine(scene), names=tuple(f"bone {joint}" for joint in range(len(NAMES))))
    assert with_legs_on_the_pelvis(nameless) is nameless
    no_pelvis = hung_on_the_spine(replace(scene, joints=np.array(NAMES) != "Hips"))
    assert with_legs_on_the_pelvis(no_pelvis) is no_pelvis
