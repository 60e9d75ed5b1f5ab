from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.generated import FEWEST_JOINTS, HANDS, MOST_JOINTS, Size, generate, skeleton_of
from motionsplice.motion import quaternion
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.roles import find_roles
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice


@pytest.mark.parametrize("joints", [FEWEST_JOINTS, 16, 17, 18, 19, 20, 21, 22, 31, 64, 200, MOST_JOINTS])
def test_a_body_has_the_requested_joints_and_every_role(joints: int) -> None:
    skeleton = skeleton_of(joints)
    roles = find_roles(skeleton)
    assert skeleton.joint_count == joints
    assert len(roles.spine) == 1 + min(joints - FEWEST_JOINTS, 2)
    assert {roles.left_wrist, roles.right_wrist} <= set(skeleton.subtree(roles.pelvis))
    assert roles.left_knee not in skeleton.subtree(roles.pelvis)


@pytest.mark.parametrize("size", [Size(joints=22, clips=5, seconds=4.0), Size(joints=200, clips=1, seconds=3.0)])
def test_a_generated_bank_is_valid_and_has_the_requested_size(size: Size, tmp_path: Path) -> None:
    bank = generate(tmp_path / "bank", size)
    assert len(bank.clips) == size.clips
    assert all(clip.duration == pytest.approx(size.seconds) and clip.rate == size.rate for clip in bank.clips)
    assert bank.skeleton.joint_count == size.joints
    assert not list((tmp_path / "bank" / "tables").glob("partial*"))
    for clip in bank.clips:
        motion = bank.motion(clip.name, seam=True)
        turned = quaternion.angle(motion.rotations[1:], motion.rotations[:-1])
        assert 0.0 < turned.max() < 0.5
        alignment = np.sum(motion.rotations[1:] * motion.rotations[:-1], axis=-1)
        assert alignment.min() > 0.0


def test_an_action_of_a_generated_bank_continues_smoothly_past_its_end(tmp_path: Path) -> None:
    bank = generate(tmp_path / "bank", Size(joints=22, clips=2, seconds=5.0), seed=3)
    upper = [joint for joint in bank.skeleton.subtree(bank.roles.pelvis) if joint != bank.roles.pelvis]
    evaluator, (own, other) = Evaluator(bank), (clip.name for clip in bank.clips)
    frames = evaluator.action_frames(Splice(own, other, start=4.0), evaluator.frame_times(own))
    assert np.diff(frames).min() < 0.0  # the action was repeated
    rotations = evaluator.clip(Splice(own, other, start=4.0)).rotations[:, upper]
    assert quaternion.angle(rotations[1:], rotations[:-1]).max() < 0.2  # without a jump


def test_more_clips_than_motions_repeat_the_motions_in_their_own_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("bench.generated.MOST_DRAWN", 2 * Size(seconds=3.0).rows)
    bank = generate(tmp_path / "bank", Size(joints=15, clips=5, seconds=3.0))
    motions = [bank.motion(clip.name).rotations for clip in bank.clips]
    np.testing.assert_array_equal(motions[0], motions[2])
    np.testing.assert_array_equal(motions[1], motions[3])
    assert np.abs(motions[0] - motions[1]).max() > 0.1
    assert len({clip.first_row for clip in bank.clips}) == 5


@pytest.mark.parametrize("joints", [15, 52])
def test_every_clip_has_hands_that_move_fingers_if_the_body_has_any(tmp_path: Path, joints: int) -> None:
    bank = generate(tmp_path / "bank", Size(joints, clips=3, seconds=3.0, hands=True))
    assert [(one.name, one.body) for one in bank.hands] == [(HANDS, clip.name) for clip in bank.clips]
    evaluator, name = Evaluator(bank), bank.clips[1].name
    apart = np.abs(
        evaluator.pose(Splice(name, hands=HANDS), 1.0).rotations - evaluator.pose(Splice(name), 1.0).rotations
    )[0]
    changed = np.flatnonzero(apart.max(axis=1) > 1e-4).tolist()
    assert changed == list(bank.layout.hands.joints)
    assert bool(changed) == (joints == 52)


def test_the_same_seed_makes_the_same_bank(tmp_path: Path) -> None:
    size = Size(joints=15, clips=2, seconds=3.0)
    digests = [generate(tmp_path / name, size, seed).digest for name, seed in (("a", 1), ("b", 1), ("c", 2))]
    assert digests[0] == digests[1] != digests[2]
    assert Bank.open(tmp_path / "a").digest == digests[0]


@pytest.mark.parametrize("wrong", [{"joints": 14}, {"joints": 301}, {"clips": 0}, {"seconds": 1.0}])
def test_an_invalid_size_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(SettingsError, match="cannot be generated"):
        Size(**wrong)
