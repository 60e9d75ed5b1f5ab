from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion.pointcloud import level, planar_distances
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.baseline import Baseline, find_baseline
from motionsplice.precompute.alignment.ring import wind
from motionsplice.precompute.alignment.typical import (
    DECIMALS,
    MOST_CANDIDATES,
    OTHER_GAIT,
    distance_to_all,
    most_typical,
)


def stride(locomotion: str, seed: int = 0) -> Baseline:
    clip = make(locomotion, seed=seed)
    return find_baseline(replace(clip, name=f"{locomotion} {seed}"), find_roles(clip.skeleton))


def made_up(name: str, cells: int, loop: float, like: Floats, departure: float, rng: np.random.Generator) -> Baseline:
    """A stride that departs from the clouds `like` [n, 3, 3] over the cycle; its legs are 0.9 m long."""
    at = np.arange(cells) / cells
    clouds = np.stack([np.interp(at, np.arange(len(like)) / len(like), one) for one in like.reshape(-1, 9).T], axis=1)
    waves = np.stack([np.cos(2.0 * np.pi * at), np.sin(2.0 * np.pi * at)], axis=1)
    clouds += departure * waves @ rng.normal(size=(2, 9))
    return Baseline(name, 0.0, 1.0, loop, 0.9, 0.0, clouds.reshape(-1, 3, 3), np.zeros((cells, 2)))


def distances_to(candidate: Baseline, strides: list[Baseline]) -> list[float]:
    """The slow twin: each stride, two laps long, wound round the candidate's ring."""
    found = []
    for one in strides:
        laps = np.tile(one.clouds / one.leg, (2, 1, 1))
        distances = planar_distances(level(laps), level(candidate.clouds / candidate.leg))
        wound = wind(distances) % len(candidate.clouds)
        found.append(min(float(np.sqrt(distances[np.arange(len(laps)), wound].mean())), OTHER_GAIT))
    return found


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, MOST_CANDIDATES + 6))
def test_the_choice_is_that_of_the_slow_twin_which_leaves_out_nothing(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    gaits = [0.4 * rng.normal(size=(6, 3, 3)) for _ in range(2)]
    strides = []
    for k in range(count):
        cells, loop, gait = int(rng.integers(10, 18)), rng.random(), gaits[rng.integers(2)]
        strides.append(made_up(f"{k % 7}-{k}", cells, loop, gait, 0.02 * rng.random(), rng))
    strides.append(replace(strides[0], name="the same"))
    candidates = sorted(strides, key=lambda one: (one.loop, one.name))[:MOST_CANDIDATES]
    wanted = min(candidates, key=lambda one: (round(sum(distances_to(one, strides)), DECIMALS), one.name))
    assert most_typical(strides) is wanted


def test_the_distance_to_all_is_that_of_the_slow_twin() -> None:
    rng = np.random.default_rng(3)
    gait = 0.4 * rng.normal(size=(6, 3, 3))
    strides = [made_up(str(k), 12 + k, 0.0, gait, 0.03, rng) for k in range(5)]
    strides.append(made_up("other", 14, 0.0, 3.0 * gait, 0.0, rng))
    centred = [one.clouds / one.leg - (one.clouds / one.leg).mean(axis=1, keepdims=True) for one in strides]
    ends = np.cumsum([len(one) for one in centred])
    for one, ring in zip(strides, centred, strict=True):
        apart = distance_to_all(np.concatenate(centred), ends, ring, np.inf)
        np.testing.assert_allclose(apart, sum(distances_to(one, strides)), rtol=1e-6)
        assert distance_to_all(np.concatenate(centred), ends, ring, 0.5 * apart) == np.inf


def test_leaps_of_all_kinds_do_not_outvote_three_walks() -> None:
    walks, run = [stride("walk", seed) for seed in range(3)], stride("run")
    leaps = [replace(run, name=f"leap {k}", clouds=run.clouds * np.array([k, 1.0, k])) for k in (2.0, 3.0, 4.0, 5.0)]
    assert most_typical([*walks, run, *leaps]).name.startswith("walk")
