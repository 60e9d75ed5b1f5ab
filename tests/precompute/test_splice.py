from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.quality.measures import posture_error, upper_body_errors
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError, SkeletonError
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.variants import local_axes, uneven_time, warped, with_local_axes
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.alignment.working_rate import WORKING_RATE
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.job.bank_builder import write_bank
from motionsplice.precompute.preparation.prepared import prepare
from motionsplice.precompute.preparation.torso_offset import MeanStride, torso_offsets
from motionsplice.precompute.splice import Posture, align_in_time, splice_exact, splice_naive
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from tests.conftest import CLIPS

WALK, BOX, CURVE = CLIPS["walk"], CLIPS["carry_box"], CLIPS["turn_180"]
ROLES = find_roles(WALK.skeleton)


def bank_of(folder: Path, *clips: Clip) -> Bank:
    """Returns a bank of clips on one skeleton, whose baseline is the first clip."""
    ring, rig = find_baseline(clips[0], ROLES), Rig(clips[0].skeleton, ROLES)
    prepared = [prepare(clip, ROLES, rig, ring) for clip in {clip.name: clip for clip in clips}.values()]
    settled = [replace(one, neutral=clips[0].name) for one in prepared]
    write_bank(folder, rig, ring, {one.name: one for one in settled})
    return Bank.open(folder)


def offsets_of(action: Clip, neutral: Clip) -> Floats:
    """Returns the torso offsets of an action, aligned to its neutral's stride."""
    ring = find_baseline(neutral, ROLES)
    stride = MeanStride.of(measure_torso(neutral, ROLES).upright, align(neutral, ROLES, ring).phase)
    return torso_offsets(measure_torso(action, ROLES).upright, align(action, ROLES, ring).phase, action.rate, stride)


@pytest.mark.parametrize("name", sorted(CLIPS))
@pytest.mark.parametrize("posture", ["off", "relative", "absolute"])
def test_a_clip_spliced_onto_itself_changes_by_less_than_a_tenth_of_a_millimetre(name: str, posture: Posture) -> None:
    clip = CLIPS[name]
    result = splice_exact(clip, clip, ROLES, posture=posture).clip
    assert result.frame_count >= clip.frame_count - clip.rate / 30.0
    apart = joint_positions(result) - joint_positions(clip)[: result.frame_count]
    assert np.linalg.norm(apart, axis=-1).max() < 1e-4


@pytest.mark.parametrize("name", sorted(CLIPS))
def test_pairwise_alignment_recovers_a_warp(name: str) -> None:
    clip = CLIPS[name]
    frames = uneven_time(clip.frame_count)
    found = align_in_time(warped(clip, frames, "uneven"), clip, ROLES)[1]
    error = np.abs(found - frames[: len(found)])
    assert np.median(error) < 0.5
    assert np.percentile(error, 95) < 2.0


@pytest.mark.parametrize("name", ["walk", "run", "carry_box", "wave"])
def test_the_bank_recovers_a_warp(name: str, tmp_path: Path) -> None:
    clip = replace(CLIPS[name], name=name)
    frames = uneven_time(clip.frame_count)
    bank = bank_of(tmp_path, WALK, clip, warped(clip, frames, "uneven"))
    even, uneven = (bank.tables["phase_of_frame"][rows_of(bank, one)] for one in (name, "uneven"))
    uneven = uneven - np.round(np.median(uneven - np.interp(frames, np.arange(clip.frame_count), even)))
    error = np.abs(np.interp(uneven, even, np.arange(clip.frame_count)) - frames) * (WORKING_RATE / clip.rate)
    assert np.median(error) < 0.5
    assert np.percentile(error, 95) < 2.0


def rows_of(bank: Bank, name: str) -> slice:
    clip = bank.clip(name)
    return slice(clip.first_row, clip.first_row + clip.frame_count)


@pytest.mark.parametrize("posture", ["off", "relative", "absolute"])
def test_the_answer_does_not_depend_on_local_axes(posture: Posture, tmp_path: Path) -> None:
    axes = local_axes(WALK.skeleton.joint_count, seed=8)
    turned = [with_local_axes(clip, axes) for clip in (WALK, CURVE, BOX)]
    np.testing.assert_allclose(joint_positions(turned[1]), joint_positions(CURVE), atol=1e-9)
    plain = splice_exact(CURVE, BOX, ROLES, posture=posture, torso_offsets=(None, offsets_of(BOX, WALK))).clip
    offsets = None, offsets_of(turned[2], turned[0])
    other = splice_exact(turned[1], turned[2], ROLES, posture=posture, torso_offsets=offsets).clip
    np.testing.assert_allclose(joint_positions(other), joint_positions(plain), atol=1e-6)
    banks = bank_of(tmp_path / "plain", WALK, CURVE, BOX), bank_of(tmp_path / "turned", *turned)
    first, second = (
        joint_positions(Evaluator(bank).clip(Splice(CURVE.name, BOX.name, posture=posture))) for bank in banks
    )
    np.testing.assert_allclose(first, second, atol=1e-4)


def test_absolute_posture_gives_the_actions_posture(bank: Bank) -> None:
    for locomotion in ("walk", "run", "side_step", "stairs_up"):
        exact = splice_exact(CLIPS[locomotion], BOX, ROLES, posture="absolute").clip
        assert np.degrees(posture_error(exact, BOX, ROLES)) < 0.5
        result = Evaluator(bank).clip(Splice(locomotion, "carry_box", posture="absolute"))
        assert np.degrees(posture_error(result, bank.motion("carry_box"), bank.roles)) < 1.5


def test_both_halves_keep_their_rotations() -> None:
    splice = splice_exact(CURVE, BOX, ROLES, posture="absolute")
    upper = [joint for joint in CURVE.skeleton.subtree(ROLES.pelvis) if joint != ROLES.pelvis]
    lower = [joint for joint in range(CURVE.skeleton.joint_count) if joint not in {*upper, ROLES.pelvis}]
    result, count = splice.clip, splice.clip.frame_count
    assert quaternion.angle(result.rotations[:, lower], CURVE.rotations[:count, lower]).max() < 1e-7
    sampled = BOX.sampled(splice.action_frames)[1]
    assert quaternion.angle(result.rotations[:, upper], sampled[:, upper]).max() < 1e-7
    np.testing.assert_array_equal(result.root_positions, CURVE.root_positions[:count])
    assert np.diff(splice.action_frames).min() > 0.0


def test_naive_copies_degrees_of_freedom_and_repeats_the_action() -> None:
    naive = splice_naive(WALK, CLIPS["wave"], ROLES)
    upper, period = WALK.skeleton.subtree(ROLES.pelvis), CLIPS["wave"].frame_count - 1
    assert quaternion.angle(naive.rotations[period + 5, upper], CLIPS["wave"].rotations[5, upper]).max() < 1e-6
    assert naive.frame_count == WALK.frame_count


def test_rigs_that_differ_are_refused() -> None:
    other = WALK.skeleton
    renamed = Clip(
        "other",
        type(other)(("Root", *other.names[1:]), other.parents, other.offsets, other.end_parents, other.end_offsets),
        WALK.rate,
        WALK.root_positions,
        WALK.rotations,
    )
    with pytest.raises(SkeletonError, match="different joints"):
        splice_exact(WALK, renamed, ROLES)


@pytest.mark.parametrize("frames", [(0, 40), (0, 8), (80, 82), (80, 81)])
def test_an_action_that_is_in_step_too_briefly_is_refused(frames: tuple[int, int]) -> None:
    with pytest.raises(ClipError, match=r"'carry_box': .* less than 0\.3 s.*--method splice.*repeats"):
        splice_exact(WALK, replace(BOX.frames(*frames), name="carry_box"), ROLES)
    with pytest.raises(ClipError, match=r"less than 0\.3 s"):
        splice_exact(WALK.frames(0, 8), BOX, ROLES)


def test_a_splice_of_real_walks_is_nearer_to_the_truth_than_a_naive_one(real_motion: Path) -> None:
    curve, walk = (read_clip(real_motion / f"{name}.amc") for name in ("16_17", "16_15"))
    truth, roles = curve.clip, curve.roles
    exact = splice_exact(truth, walk.clip, roles, posture="off").clip
    ratio = (
        upper_body_errors(exact, truth, roles).mean()
        / upper_body_errors(splice_naive(truth, walk.clip, roles).frames(0, exact.frame_count), truth, roles).mean()
    )
    assert ratio < 0.35
