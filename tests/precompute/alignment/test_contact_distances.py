from __future__ import annotations

import numpy as np
import pytest

from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.alignment.contact_distances import WEIGHT, contact_distances
from motionsplice.precompute.body.contacts import foot_contacts
from motionsplice.runtime.format.contacts import FEET


def test_a_foot_that_stands_in_one_of_both_only_is_worth_the_weight() -> None:
    support, ring = np.array([[1.0, 0.0], [1.0, 1.0]]), np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.0]])
    found = contact_distances(support, ring, leg=0.8) / (WEIGHT * 0.8) ** 2
    np.testing.assert_allclose(found, [[0.0, 2.0, 0.25], [1.0, 1.0, 1.25]])


@pytest.mark.parametrize("name", ["side_step", "stairs_down", "stairs_up", "walk"])
def test_feet_touch_down_as_in_the_baseline(name: str) -> None:
    """By its knees alone, the side-step's right foot touches down a sixth of a stride late."""
    walk, clip = make("walk", seconds=6.0), make(name, seconds=6.0)
    roles = find_roles(walk.skeleton)
    phase = align(clip, roles, find_baseline(walk, roles)).phase
    standing = foot_contacts(clip, roles)
    for bit, wanted in zip(FEET.values(), (0.0, 0.5), strict=True):
        downs = np.flatnonzero(np.diff((standing & bit > 0).astype(np.int8)) > 0)
        late = (phase[downs] - wanted + 0.5) % 1.0 - 0.5
        assert abs(np.median(late)) < 0.12
