from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from motionsplice.motion.clip import Clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.body.contacts import LOADING, foot_contacts, support
from motionsplice.precompute.body.joint_paths import joint_paths
from motionsplice.precompute.preparation.feet import FIRM, LOOSE, root_steps
from motionsplice.precompute.preparation.seam import add_seam
from motionsplice.runtime.format.contacts import FEET, LEFT_FOOT

ROLES = find_roles(make("walk", seconds=1.0).skeleton)
slips = arrays(np.float64, (5, 2, 2), elements=st.floats(-0.1, 0.1))
supports = arrays(np.float64, (5, 2), elements=st.floats(0.0, 1.0))


@given(slips, st.floats(FIRM, 1.0), st.floats(0.0, LOOSE), st.booleans())
def test_a_foot_that_stands_alone_does_not_slip(slips: Floats, firm: float, loose: float, left: bool) -> None:
    both = np.tile([firm, loose] if left else [loose, firm], (5, 1))
    np.testing.assert_allclose(root_steps(slips, both), -slips[:, 0 if left else 1], atol=1e-12)


@given(slips, supports)
def test_the_root_moves_no_more_than_the_feet_slip(slips: Floats, supports: Floats) -> None:
    moved = np.linalg.norm(root_steps(slips, supports), axis=1)
    assert np.all(moved <= np.linalg.norm(slips, axis=2).max(axis=1) + 1e-12)
    np.testing.assert_allclose(root_steps(slips[:, ::-1], supports[:, ::-1]), root_steps(slips, supports), atol=1e-12)
    assert not root_steps(slips, np.zeros((5, 2))).any()


def test_a_preferred_foot_counts_more() -> None:
    slips = np.array([[[0.1, 0.0], [0.0, 0.0]]])
    equal, preferred = (root_steps(slips, np.ones((1, 2)), factors)[0, 0] for factors in ((1.0, 1.0), (1.0, 0.25)))
    assert (equal, preferred) == (pytest.approx(-0.05), pytest.approx(-0.08))


@pytest.mark.parametrize("rate", [30.0, 60.0, 120.0])
def test_support_rises_within_the_time_of_loading(rate: float) -> None:
    standing = np.where(np.arange(200) >= 100, LEFT_FOOT, 0).astype(np.uint8)
    left, right = support(standing, rate).T
    changing = np.flatnonzero((left > 1e-9) & (left < 1.0 - 1e-9))
    assert not right.any()
    assert left[99] == pytest.approx(1.0 - left[100])
    assert np.all(np.diff(left) >= -1e-12)
    assert (changing[-1] - changing[0]) / rate == pytest.approx(LOADING, abs=2.0 / rate)


@pytest.mark.parametrize("name", ["slow_walk", "stairs_down", "stairs_up", "run", "side_step"])
def test_a_foot_that_stands_in_a_seam_does_not_slide(name: str) -> None:
    """Without the root steps, the slow walk slides by 8 cm here."""
    clip, walk = make(name, seconds=6.0), make("walk", seconds=6.0)
    phase = align(clip, ROLES, find_baseline(walk, ROLES)).phase
    seamed = add_seam(clip, phase, ROLES, foot_contacts(clip, ROLES))
    assert max(slides(seamed.clip, clip.frame_count - 1)) < 0.015


def slides(clip: Clip, first: int) -> list[float]:
    """Returns how far each foot goes over the ground while it stands in frames from `first` on, metres."""
    standing, found = foot_contacts(clip, ROLES)[first:], []
    for bit, joints in zip(FEET.values(), ROLES.feet, strict=True):
        moves = np.diff(joint_paths(clip, joints)[first:][..., [0, 2]], axis=0)
        least = np.linalg.norm(moves, axis=2).argmin(axis=1)
        steps = moves[np.arange(len(moves)), least] * (standing[1:] & standing[:-1] & bit > 0)[:, None]
        found.append(float(np.linalg.norm(np.ptp(np.cumsum(steps, axis=0), axis=0))))
    return found
