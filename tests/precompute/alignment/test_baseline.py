from __future__ import annotations

import numpy as np

from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline


def test_a_steady_walk_has_a_steady_phase_to_its_ends() -> None:
    clip = make("walk", seed=1, seconds=6.0)
    roles = find_roles(clip.skeleton)
    pace = np.diff(align(clip, roles, find_baseline(clip, roles)).phase)
    np.testing.assert_allclose(pace, np.median(pace), rtol=0.12)
