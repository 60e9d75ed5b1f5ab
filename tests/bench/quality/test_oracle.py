from __future__ import annotations

import numpy as np
import pytest

from bench.quality.measures import upper_body_errors
from bench.quality.oracle import oracle_error
from motionsplice.motion import quaternion
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.splice import splice_exact
from tests.conftest import CLIPS

WALK = CLIPS["walk"]
ROLES = find_roles(WALK.skeleton)
RING = find_baseline(WALK, ROLES)


def no_offsets(*frames: int) -> tuple[quaternion.Floats, quaternion.Floats]:
    first, second = (np.tile(quaternion.IDENTITY, (count, 1)) for count in frames)
    return first, second


def test_an_oracle_finds_a_clips_own_frames() -> None:
    assert oracle_error(WALK, WALK, WALK, no_offsets(WALK.frame_count, WALK.frame_count), ROLES) < 1e-9


@pytest.mark.parametrize("locomotion", ["curve", "run"])
def test_an_oracle_is_closer_than_a_splice(locomotion: str) -> None:
    clip, action = make(locomotion, seed=5), make("walk", "wave", seed=6)
    truth = make(locomotion, "wave", seed=5)
    splice = splice_exact(clip, action, ROLES, posture="off")
    frame_count = splice.clip.frame_count
    error = oracle_error(clip.frames(0, frame_count), action, truth, no_offsets(frame_count, action.frame_count), ROLES)
    assert error < upper_body_errors(splice.clip, truth, ROLES).mean()
