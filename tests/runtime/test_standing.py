"""Standing actions at run time: in the evaluator and in characters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.parts import part_of_joint
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.precompute.hands.settings import HandsOnBody
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.splice import splice_standing
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.mirrored import MIRRORED
from motionsplice.runtime.requests import POSTURES, Requests
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage
from tests import naive, naive_character
from tests.conftest import CLIPS
from tests.playing import RATE, Setup, evaluated
from tests.runtime.characters.test_characters import commanded

ACTIONS = ("bow", "hail", "holding", "jab")
LEFT_ARM, RIGHT_ARM = 1, 2  # numbers of parts


@pytest.fixture(scope="module")
def standing_stage(standing_bank: Bank) -> Stage:
    return Stage(Evaluator(standing_bank))


@pytest.fixture
def one(standing_stage: Stage) -> Setup:
    return lambda: Characters(standing_stage, RATE)


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_poses_agree_with_the_twin(standing_bank: Bank, data: st.DataObject) -> None:
    bank = standing_bank
    locomotion, action = (data.draw(st.sampled_from(bank.numbered)) for _ in range(2))
    time, posture = data.draw(st.floats(0.0, locomotion.duration)), data.draw(st.sampled_from(["relative", "off"]))
    start = data.draw(st.floats(0.0, action.duration))
    asked: Any = posture
    splice = Splice(locomotion.name, action.name, start=start, posture=asked)
    found = Evaluator(bank).pose(splice, time)
    root, rotations = naive.pose(bank, locomotion.name, time, action.name, start, "splice", posture)
    np.testing.assert_allclose(found.root_positions[0], root, atol=1e-5)
    assert quaternion.angle(found.rotations[0], rotations).max() < 5e-5


@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.parametrize("locomotion", ["walk", "run~mirror"])
def test_the_evaluator_does_what_the_whole_clip_splice_does(standing_bank: Bank, locomotion: str, action: str) -> None:
    standing, clips = standing_bank.standing(action), (standing_bank.motion(locomotion), standing_bank.motion(action))
    assert standing is not None
    whole = splice_standing(*clips, standing_bank.roles, standing)
    frames = round(min(one.duration for one in clips) * whole.rate)
    found = Evaluator(standing_bank).clip(Splice(locomotion, action))
    assert quaternion.angle(found.rotations[:frames], whole.rotations[:frames]).max() < 5e-5


def test_a_standing_action_plays_at_its_own_speed_and_repeats_from_its_start(standing_bank: Bank) -> None:
    evaluator, entry = Evaluator(standing_bank), standing_bank.clip("bow")
    times = np.array([0.0, 0.5, 1.0, 1.5])
    for locomotion in ("walk", "run", "idle"):
        frames = evaluator.action_frames(Splice(locomotion, "bow", start=1.0), times[:2])
        np.testing.assert_allclose(frames, (1.0 + times[:2]) * entry.rate)
    frames = evaluator.action_frames(Splice("walk", "bow", start=entry.duration), times)
    last, begun = entry.row_count - 1.0, entry.row_count - entry.frame_count + 1.0  # the seam leads to frame 1 and on
    expected = (entry.duration + times) * entry.rate
    np.testing.assert_allclose(frames, np.where(expected > last, expected - last + begun, expected), atol=1e-6)


def test_a_standing_action_goes_on_when_its_locomotion_has_gone_back(standing_bank: Bank) -> None:
    """`cycles` then grow by the strides of the loop, as for an action in step."""
    walk, evaluator, requests = standing_bank.clip("walk"), Evaluator(standing_bank), Requests.empty(2)
    poses = evaluator.poses(2)
    requests.records[:] = evaluator.record(Splice("walk", "jab"))
    requests.time[:] = 0.1
    requests.cycles[0] = walk.loop
    requests.start[1] = naive.frames_in_loop(standing_bank, "walk") / walk.rate
    evaluator.evaluate(requests, poses)
    np.testing.assert_allclose(poses.rotations[0], poses.rotations[1], atol=1e-5)
    requests.cycles[:], requests.start[:] = [-100, 0], 0.0
    requests.time[1] = 0.0
    evaluator.evaluate(requests, poses)
    arm = standing_bank.roles.right_shoulder  # the first frame is at rest, where the arm swings on
    walking = standing_bank.motion("walk").rotations[[6, 0], arm]
    assert quaternion.angle(poses.rotations[:, arm], walking).max() < np.radians(2.0)


def test_what_an_action_does_not_use_moves_as_in_the_locomotion(standing_bank: Bank) -> None:
    evaluator, parts = Evaluator(standing_bank), part_of_joint(standing_bank.skeleton, standing_bank.roles)
    splice, walk = evaluator.clip(Splice("walk", "hail")), standing_bank.motion("walk")
    arm = np.flatnonzero(parts == LEFT_ARM)
    assert quaternion.angle(splice.rotations[:, arm], walk.rotations[:, arm]).max() < np.radians(1.0)
    swing = quaternion.angle(walk.rotations[:, arm], walk.rotations[0, arm]).max()
    assert swing > np.radians(20.0)


def test_arms_that_an_action_uses_are_posed_by_it_alone(standing_bank: Bank) -> None:
    evaluator, standing = Evaluator(standing_bank), standing_bank.standing("hail")
    assert standing is not None
    raised = np.flatnonzero(standing.usage[:, RIGHT_ARM] > 0.9999)
    arm = np.flatnonzero(part_of_joint(standing_bank.skeleton, standing_bank.roles) == RIGHT_ARM)
    splice, hail = evaluator.clip(Splice("walk", "hail")), standing_bank.motion("hail")
    assert len(raised) > 100
    apart = quaternion.angle(splice.rotations[raised][:, arm], hail.rotations[raised][:, arm])
    assert apart.max() < 2e-3


def test_a_mirror_image_on_a_mirror_image_is_the_mirrored_splice(standing_bank: Bank) -> None:
    evaluator, mirror = Evaluator(standing_bank), standing_bank.mirror
    assert isinstance(mirror, Mirror)
    for action in ACTIONS:
        straight, mirrored = (evaluator.clip(Splice("walk" + one, action + one)) for one in ("", MIRRORED))
        assert quaternion.angle(mirrored.rotations, mirror.clip(straight).rotations).max() < 5e-5
    assert standing_bank.clip("hail").uses == ("right arm",)
    assert standing_bank.clip("hail~mirror").uses == ("left arm",)


def test_a_mask_in_the_settings_poses_these_parts_at_every_frame(standing_bank: Bank) -> None:
    parts, walk = part_of_joint(standing_bank.skeleton, standing_bank.roles), standing_bank.motion("walk")
    splice, held = Evaluator(standing_bank).clip(Splice("walk", "holding")), standing_bank.motion("holding")
    arms = np.isin(parts, [LEFT_ARM, RIGHT_ARM])
    assert quaternion.angle(splice.rotations[:50, arms], held.rotations[:50, arms]).max() < 1e-4
    assert quaternion.angle(splice.rotations[:, ~arms], walk.rotations[:, ~arms]).max() < 1e-5


def test_other_postures_are_the_papers_and_take_the_whole_upper_body(standing_bank: Bank) -> None:
    evaluator, pelvis = Evaluator(standing_bank), standing_bank.roles.pelvis
    upper = standing_bank.skeleton.subtree(pelvis)[1:]
    for posture in sorted(POSTURES.keys() - {"relative"}):
        asked: Any = posture
        splice = evaluator.clip(Splice("walk", "hail", posture=asked))
        whole = standing_bank.motion("hail").rotations[: splice.frame_count, upper]
        assert quaternion.angle(splice.rotations[:, upper], whole).max() < 1e-5


def test_a_character_shows_the_evaluators_splice_and_its_own_motion_without_weight(one: Setup) -> None:
    whole, none, alone = one(), one(), one()
    for characters in (whole, none, alone):
        characters.add(1, "walk")
    whole.act([0], Action("jab", blend=0.0))
    none.act([0], Action("jab", blend=0.0, weight=0.0))
    for frame in range(240):
        pose = whole.stage.evaluator.pose(Splice("walk", "jab"), frame / RATE)
        np.testing.assert_allclose(evaluated(whole)[1][0, 1:], pose.rotations[0, 1:], atol=3e-6)
        np.testing.assert_allclose(evaluated(none)[1], evaluated(alone)[1], atol=1e-6)
        for characters in (whole, none, alone):
            characters.advance()


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 2**32 - 1))
def test_characters_agree_with_the_twin(one: Setup, seed: int) -> None:
    draw, characters = np.random.default_rng(seed), one()
    for name in draw.choice([clip.name for clip in characters.stage.bank.numbered], 3):
        characters.add(1, str(name))
    commanded(characters, draw, 60)
    naive_character.check(characters)


def test_own_clock_is_the_default_of_standing_actions_only(one: Setup, standing_bank: Bank) -> None:
    characters = one()
    characters.add(3, "run")
    for row, (action, own_clock) in enumerate((("hail", None), ("hail", False), ("walk", None))):
        characters.act([row], Action(action, blend=0.0, own_clock=own_clock))
    before = characters.state[:, col.FIRST_ACTION + col.FRAME].copy()
    for _ in range(60):
        characters.advance()
    passed = characters.state[:, col.FIRST_ACTION + col.FRAME] - before
    rate = standing_bank.clip("hail").rate
    assert passed[0] == pytest.approx(rate * 60 / RATE)
    assert abs(passed[1] - rate * 60 / RATE) > 5.0
    assert passed[2] > 1.2 * rate * 60 / RATE  # a run hurries a walk


def test_a_standing_action_gives_no_phase_to_a_gait_that_follows(one: Setup) -> None:
    characters = one()
    characters.add(1, "idle")
    characters.act([0], Action("hail", blend=0.0))
    for _ in range(37):
        characters.advance()
    characters.play([0], "walk", time=0.5, blend=0.0)
    assert characters.state[0, col.FIRST_LOCOMOTION + col.FRAME] == pytest.approx(30.0)


@pytest.mark.parametrize("mask", list(col.MASKS))
@pytest.mark.parametrize("frame", [30, 90, 130, 190])
def test_starting_and_stopping_at_any_time_does_not_pop(one: Setup, frame: int, mask: Any) -> None:
    characters = one()
    characters.add(1, "walk")
    poses = []
    for number in range(frame + 60):
        if number == 20:
            characters.act([0], Action("jab", start=1.2, blend=0.25, mask=mask))
        if number == frame:
            characters.stop([0], blend=0.25)
        poses.append(evaluated(characters)[1][0])
        characters.advance()
    turned = quaternion.angle(np.array(poses)[1:], np.array(poses)[:-1]).max(axis=1)
    bank = characters.stage.bank
    sources = [bank.motion(name).rotations for name in ("walk", "jab")]
    fastest = max(quaternion.angle(one[1:], one[:-1]).max() for one in sources)
    assert turned.max() < 1.6 * fastest


@pytest.fixture(scope="module")
def gesture_stage(tmp_path_factory: pytest.TempPathFactory) -> Stage:
    """A walk, a person who stands and gestures, and the hands of these gestures."""
    pair = gesture_pair(5, kinds=["count", "point"], seconds=4.0, locomotion=None)
    folder = tmp_path_factory.mktemp("gestures")
    for name, clip in {"walk": CLIPS["walk"], "counting": pair.body, "counting_hands": pair.hands}.items():
        (folder / f"{name}.bvh").write_bytes(dump_bvh(clip))
    (folder / "clips.toml").write_text("[counting]\nkind = 'action'\n")
    hands = HandsOnBody("counting", "counting_hands")
    assert not build_bank([folder], folder / "bank", baseline="walk", hands=[hands]).failed
    return Stage(Evaluator(Bank.open(folder / "bank")))


def test_hands_lie_on_a_standing_action(gesture_stage: Stage) -> None:
    bank, characters = gesture_stage.bank, Characters(gesture_stage, RATE)
    assert bank.clip("counting").stands
    characters.add(2, "walk")
    characters.act([0, 1], Action("counting", blend=0.1))
    characters.wear([0], "counting_hands", blend=0.1)
    fingers = [joint for joint in bank.layout.hands.joints if "Thumb" in bank.skeleton.names[joint]]
    moved = 0.0
    for frame in range(200):
        before = characters.state.copy()
        rotations = evaluated(characters)[1]
        if frame % 20 == 3:
            for row, state in enumerate(before):
                assert quaternion.angle(rotations[row], naive_character.pose(bank, state)[1]).max() < 1e-3
        moved = max(moved, quaternion.angle(rotations[0, fingers], rotations[1, fingers]).max())
        characters.advance()
    assert moved > 0.2
    splice = Splice("walk", "counting", hands="counting_hands")
    worn = gesture_stage.evaluator.pose(splice, 2.0).rotations[0]
    twin = naive.pose(bank, "walk", 2.0, "counting", 0.0, "splice", "relative", hands="counting_hands")[1]
    assert quaternion.angle(worn, twin).max() < 5e-5


def test_positions_of_feet_and_root_are_the_locomotions(standing_bank: Bank) -> None:
    evaluator, roles = Evaluator(standing_bank), standing_bank.roles
    legs = [
        joint
        for joint in range(standing_bank.skeleton.joint_count)
        if joint not in standing_bank.skeleton.subtree(roles.pelvis)
    ]
    for action in ACTIONS:
        apart = (
            joint_positions(evaluator.clip(Splice("run", action)))[:, legs]
            - joint_positions(standing_bank.motion("run"))[:, legs]
        )
        assert np.abs(apart).max() < 1e-5
