from __future__ import annotations

from dataclasses import replace

import numpy as np

from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import Baseline, find_baseline, most_typical


def stride(locomotion: str, seed: int = 0) -> Baseline:
    clip = make(locomotion, seed=seed)
    return find_baseline(replace(clip, name=f"{locomotion} {seed}"), find_roles(clip.skeleton))


def test_leaps_of_all_kinds_do_not_outvote_three_walks() -> None:
    walks, run = [stride("walk", seed) for seed in range(3)], stride("run")
    leaps = [replace(run, name=f"leap {k}", clouds=run.clouds * np.array([k, 1.0, k])) for k in (2.0, 3.0, 4.0, 5.0)]
    assert most_typical([*walks, run, *leaps]).name.startswith("walk")


def test_a_steady_walk_has_a_steady_phase_to_its_ends() -> None:
    clip = make("walk", seed=1, seconds=6.0)
    roles = find_roles(clip.skeleton)
    pace = np.diff(align(clip, roles, find_baseline(clip, roles)).phase)
    np.testing.assert_allclose(pace, np.median(pace), rtol=0.12)
