from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.quality.additive import add
from bench.standing.__main__ import errors_of, standing_bank
from motionsplice.motion import quaternion
from motionsplice.motion.procedural.body import SKELETON
from motionsplice.motion.procedural.library import make
from motionsplice.motion.procedural.stances import BEGIN, END, Performer, fair, standing_action, standing_truth
from motionsplice.motion.roles import find_roles
from motionsplice.runtime.evaluator import Evaluator

ROLES = find_roles(SKELETON)


def test_an_added_reference_pose_changes_nothing_and_a_departure_is_added() -> None:
    walk = make("walk", seconds=2.0)
    hail = standing_action("hail", Performer(), seed=1).frames(0, walk.frame_count)
    still = replace(hail, rotations=np.repeat(hail.rotations[:1], hail.frame_count, axis=0))
    assert quaternion.angle(add(walk, still, ROLES).rotations, walk.rotations).max() < 1e-7
    added, arm = add(walk, hail, ROLES), ROLES.right_elbow
    departure = quaternion.multiply(added.rotations[100, arm], quaternion.conjugate(walk.rotations[100, arm]))
    expected = quaternion.multiply(hail.rotations[100, arm], quaternion.conjugate(hail.rotations[0, arm]))
    assert quaternion.angle(departure, expected) < 1e-7


def test_the_truth_of_an_action_is_the_locomotion_with_the_gesture() -> None:
    walk = make("walk", seed=4)
    for performer in (Performer(), fair(3)):
        truth = standing_truth("walk", "bow", performer, locomotion_seed=4)
        at = round((END + 0.3) * truth.rate), round((BEGIN - 0.3) * truth.rate)
        lower = [joint for joint in range(SKELETON.joint_count) if joint not in SKELETON.subtree(ROLES.pelvis)]
        np.testing.assert_allclose(truth.rotations[:, lower], walk.rotations[:, lower], atol=1e-12)
        assert quaternion.angle(truth.rotations[at, :], walk.rotations[at, :]).max() < 1e-6
        assert quaternion.angle(truth.rotations[150], walk.rotations[150]).max() > 0.1


def test_a_splice_is_nearer_to_the_truth_than_additive_blending(tmp_path: Path) -> None:
    performers = {"hail": fair(1), "jab": fair(2)}
    errors = errors_of(Evaluator(standing_bank(tmp_path, performers, seed=1)), performers, seed=1)
    means = {how: np.mean([one[how] for one in errors.values()]) for how in ("replaced", "additive", "offline", "bank")}
    assert means["bank"] < 0.7 * means["additive"] < 0.5 * means["replaced"]
    assert abs(means["bank"] - means["offline"]) < 0.01
