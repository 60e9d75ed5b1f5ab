from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.legs import with_legs_in_place
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
    found, _ = with_legs_in_place(hung_on_the_spine(scene))
    np.testing.assert_array_equal(found.parents, scene.parents)
    assert found.notes == ("hung on the joint that it follows: 'LeftUpLeg' on 'Hips', 'RightUpLeg' on 'Hips'",)


def test_legs_that_follow_the_spine_stay_there() -> None:
    assert np.ptp(WALK.rotations[:, SPINE], axis=0).max() > 0.01
    parents = WALK.skeleton.parents.copy()
    parents[HIPS] = SPINE
    scene = scene_of(replace(WALK, skeleton=replace(WALK.skeleton, parents=parents)))
    assert with_legs_in_place(scene)[0] is scene


def test_other_rigs_stay_as_they_are() -> None:
    scene = scene_of(WALK)
    assert with_legs_in_place(scene)[0] is scene
    nameless = replace(hung_on_the_spine(scene), names=tuple(f"bone {joint}" for joint in range(len(NAMES))))
    assert with_legs_in_place(nameless)[0] is nameless
    no_pelvis = hung_on_the_spine(replace(scene, joints=np.array(NAMES) != "Hips"))
    assert with_legs_in_place(no_pelvis)[0] is no_pelvis


def hung_on_the_root(scene: Scene, *joints: str) -> Scene:
    parents = scene.parents.copy()
    parents[[NAMES.index(joint) for joint in joints]] = 0
    return replace(scene, parents=parents)


def test_feet_at_the_end_of_the_shins_hang_on_them() -> None:
    scene = scene_of(WALK)
    found, _ = with_legs_in_place(hung_on_the_root(scene, "LeftFoot", "RightFoot"))
    np.testing.assert_array_equal(found.parents, scene.parents)
    assert "'LeftFoot' on 'LeftLeg'" in found.notes[0]


def test_feet_may_come_before_the_shins() -> None:
    """Nodes are put in order again, parent before child."""
    scene = hung_on_the_root(scene_of(WALK), "LeftFoot", "RightFoot")
    feet = [NAMES.index(name) for name in ("LeftFoot", "LeftToeBase", "RightFoot", "RightToeBase")]
    order = [0, *feet, *(joint for joint in range(1, len(NAMES)) if joint not in feet)]
    places = np.argsort(order)
    shuffled = replace(
        scene,
        names=tuple(NAMES[joint] for joint in order),
        parents=np.array([-1] + [places[scene.parents[joint]] for joint in order[1:]]),
        bind=scene.bind[order],
        world=scene.world[:, order],
    )
    found, before = with_legs_in_place(shuffled)
    assert np.all(found.parents < np.arange(len(NAMES)))
    for joint, name in enumerate(found.names):
        old = NAMES.index(name)
        assert shuffled.names[before[joint]] == name
        np.testing.assert_array_equal(found.world[:, joint], scene.world[:, old])
        assert joint == 0 or found.names[found.parents[joint]] == NAMES[WALK.skeleton.parents[old]]


def test_feet_that_leave_the_shins_stay_where_they_hang() -> None:
    scene = hung_on_the_root(scene_of(WALK), "LeftFoot")
    away = scene.world.copy()
    foot = [NAMES.index("LeftFoot"), NAMES.index("LeftToeBase")]
    away[:, foot, 1, 3] += np.linspace(0.0, 0.5, len(away))[:, None]
    left = replace(scene, world=away)
    assert with_legs_in_place(left)[0] is left
