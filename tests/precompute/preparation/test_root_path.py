from __future__ import annotations

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles, find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.body.contacts import foot_contacts
from motionsplice.precompute.preparation.root_path import root_path
from motionsplice.precompute.preparation.seam import Seamed, add_seam

WALK = make("walk", seed=1)
ROLES = find_roles(WALK.skeleton)
BASELINE = find_baseline(WALK, ROLES)


def seamed(name: str, seed: int = 2) -> Seamed:
    clip = make(name, seed=seed)
    return add_seam(clip, align(clip, ROLES, BASELINE).phase, ROLES, foot_contacts(clip, ROLES))


def path_of(one: Seamed, roles: Roles = ROLES) -> Floats:
    return root_path(one.clip, one.phase, one.strides, roles, gait=True)


def seen_from(path: Floats, root: Floats) -> Floats:
    """Returns roots [n, 3] relative to a path [n, 4]."""
    return quaternion.rotate(quaternion.about([0.0, 1.0, 0.0], -path[:, 3]), root - path[:, :3])


@pytest.mark.parametrize("name", ["walk", "run", "curve", "side_step", "turn_180"])
def test_the_root_stays_near_its_path_and_the_path_is_smooth(name: str) -> None:
    one = seamed(name)
    path, roots = path_of(one), one.clip.root_positions
    local = seen_from(path, roots)
    assert np.abs(local[30:-30, [0, 2]]).max() < 0.1
    np.testing.assert_allclose(path[:, 1], 0.0, atol=1e-12)
    assert np.abs(np.diff(path[30:-30, 3], 2)).max() < 0.002


@pytest.mark.parametrize("name", ["walk", "run", "curve", "stairs_up", "stairs_down"])
def test_the_step_at_a_loops_end_equals_the_step_where_it_continues(name: str) -> None:
    one = seamed(name)
    assert one.strides > 0
    local = seen_from(path_of(one), one.clip.root_positions)
    back = np.interp(one.phase[-1] - one.strides, one.phase, np.arange(len(local)))
    begun = [np.interp(back, np.arange(len(local)), column) for column in local.T]
    np.testing.assert_allclose(local[-1], begun, atol=1e-4)


def test_the_path_of_stairs_rises_and_the_path_of_a_turn_turns() -> None:
    up, turn = path_of(seamed("stairs_up")), path_of(seamed("turn_180"))
    assert up[-1, 1] - up[0, 1] > 1.0
    assert abs(turn[-1, 3] - turn[0, 3]) == pytest.approx(np.pi, abs=0.3)


def test_the_path_of_a_standing_clip_does_not_move() -> None:
    one = seamed("walk")
    still = one.clip.frames(0, 2)
    path = root_path(still, one.phase[:2], 0, ROLES, gait=False)
    np.testing.assert_array_equal(path[0], path[1])
