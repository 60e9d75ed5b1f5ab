from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.errors import MotionError, SettingsError, TimeRangeError, UnknownClipError
from motionsplice.motion.hand_joints import fingers_of
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import SIDES, Roles, find_roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.hands.merge import merge_hands
from motionsplice.precompute.hands.settings import HandSettings
from motionsplice.precompute.hands.splice import splice_hands
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Requests
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage
from tests import naive, naive_character, playing
from tests.conftest import COUNTING
from tests.playing import RATE, Setup


@pytest.fixture(scope="module")
def stage(hands_bank: Bank) -> Stage:
    return Stage(Evaluator(hands_bank))


def rotations_of(characters: Characters) -> Floats:
    """Returns the rotations [n, J, 4] of the characters' poses."""
    return playing.evaluated(characters)[1]


def fingers(skeleton: Skeleton, roles: Roles) -> list[int]:
    return [joint for side in SIDES for joint in fingers_of(skeleton, roles, side)]


def test_locomotion_action_and_hands_are_composed_by_table_look_up(hands_bank: Bank) -> None:
    evaluator, body = Evaluator(hands_bank), COUNTING.body
    times = np.linspace(0.0, hands_bank.clip("run").duration, 40)
    at = evaluator.action_frames(Splice("run", "counting"), times)
    at = np.where(at > body.frame_count - 1, np.nan, at)  # in the seam, hands blend into what follows
    frames = hands_bank.hand_frames("counting_hands", "counting")[:, 0]
    own = np.interp(at, np.arange(body.frame_count), frames)
    wanted = COUNTING.hands.sampled(np.nan_to_num(own))[1]
    poses = evaluator.sequence(Splice("run", "counting", hands="counting_hands"), times).rotations
    plain = evaluator.sequence(Splice("run", "counting"), times).rotations
    joints, rig = fingers(hands_bank.skeleton, hands_bank.roles), COUNTING.hands.skeleton
    their_joints = fingers(rig, find_roles(rig))
    others = [joint for joint in range(hands_bank.skeleton.joint_count) if joint not in joints]
    for pose, bare, frame, truth in zip(poses, plain, at, wanted, strict=True):
        np.testing.assert_allclose(pose[others], bare[others], rtol=0.0, atol=1e-6)  # elbows and wrists have other rows
        if not np.isnan(frame):
            assert quaternion.angle(pose[joints], truth[their_joints]).max() < 0.12  # within a key or two


@pytest.mark.parametrize("locomotion", ["run", "walk", "counting"])
def test_three_clips_are_composed_as_offline_within_a_frame(hands_bank: Bank, locomotion: str) -> None:
    """The reference: hands aligned to the action without a bank, sampled at the frames that the splice plays."""
    body, hands = COUNTING.body, COUNTING.hands
    offline = splice_hands(body, find_roles(body.skeleton), hands, find_roles(hands.skeleton), HandSettings())
    evaluator = Evaluator(hands_bank)
    times = np.linspace(0.0, hands_bank.clip(locomotion).duration, 80)
    action = evaluator.action_frames(Splice(locomotion, "counting"), times)
    within = action <= body.frame_count - 1
    assert within.sum() > 30
    laid = evaluator.sequence(Splice(locomotion, "counting", hands="counting_hands"), times).rotations[within]
    wanted = offline.clip.sampled(action[within])[1]
    for number, side in enumerate(SIDES):
        ours, theirs = (
            np.interp(action[within], np.arange(body.frame_count), one)
            for one in (hands_bank.hand_frames("counting_hands", "counting")[:, number], offline.frames[side])
        )
        assert np.abs(ours - theirs).max() < 0.1  # a whole frame would be acceptable
        joints = fingers_of(hands_bank.skeleton, hands_bank.roles, side)
        assert quaternion.angle(laid[:, joints], wanted[:, joints]).max() < 1e-3


def test_hands_of_a_bank_agree_with_the_offline_merge(hands_bank: Bank) -> None:
    body, hands = COUNTING.body, COUNTING.hands
    roles, their_roles = find_roles(body.skeleton), find_roles(hands.skeleton)
    frames = hands_bank.hand_frames("counting_hands", "counting")
    at = {side: frames[:, number] for number, side in enumerate(SIDES)}
    merged, _ = merge_hands(body, roles, hands, their_roles, at)
    laid = Evaluator(hands_bank).clip(Splice("counting", hands="counting_hands"))
    assert quaternion.angle(laid.rotations, merged.rotations).max() < 1e-3
    assert np.abs(frames[:, 0] - COUNTING.hand_frames).mean() < 3.0


def test_hands_with_wrists_change_only_the_twist_of_forearms(hands_bank: Bank) -> None:
    evaluator, roles = Evaluator(hands_bank), hands_bank.roles
    bare, laid = evaluator.clip(Splice("run")), evaluator.clip(Splice("run", hands="counting_hands"))
    for elbow, wrist in ((roles.left_elbow, roles.left_wrist), (roles.right_elbow, roles.right_wrist)):
        bone = hands_bank.skeleton.offsets[wrist]
        own, theirs = (quaternion.rotate(one.rotations[:, elbow], bone) for one in (bare, laid))
        np.testing.assert_allclose(theirs, own, atol=1e-5)
        assert quaternion.angle(bare.rotations[:, wrist], laid.rotations[:, wrist]).max() > 0.1


def test_a_looping_action_wears_hands_over_its_seam_without_a_jump(hands_bank: Bank) -> None:
    assert hands_bank.clip("counting").loop > 0
    characters = Characters(Stage(Evaluator(hands_bank)), RATE)
    characters.add(1, "walk")
    characters.act([0], Action("counting", blend=0.0))
    characters.wear([0], "counting_hands", blend=0.0)
    joints, turns = fingers(hands_bank.skeleton, hands_bank.roles), []
    for _ in range(700):
        turns.append(rotations_of(characters)[0][joints])
        characters.advance()
    steps = quaternion.angle(np.array(turns[1:]), np.array(turns[:-1])).max(axis=1)
    own = hands_bank.hand_motion("counting_hands", "counting")[: hands_bank.clip("counting").frame_count]
    assert steps.max() < 1.8 * quaternion.angle(own[1:], own[:-1]).max()


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 2**32 - 1))
def test_poses_agree_with_the_twin(one: Setup, hands_bank: Bank, seed: int) -> None:
    draw, characters = np.random.default_rng(seed), one()
    names, worn = [clip.name for clip in hands_bank.clips], [*hands_bank.hand_clips, None]
    characters.add(3, str(draw.choice(names)))
    for _ in range(40):
        for row in range(3):
            blend = float(draw.uniform(0.0, 0.6))
            kind = draw.random()
            if kind < 0.04:
                characters.wear([row], worn[draw.integers(3)], blend=blend, weight=draw.uniform(0.3, 1.0))
            elif kind < 0.06:
                mask: Any = draw.choice(list(col.MASKS))
                characters.act([row], Action(str(draw.choice(names)), blend=blend, mask=mask))
            elif kind < 0.08:
                characters.play([row], str(draw.choice(names)), blend=blend)
        characters.advance()
    before, rotations = characters.state.copy(), rotations_of(characters)
    for row, state in enumerate(before):
        assert quaternion.angle(rotations[row], naive_character.pose(hands_bank, state)[1]).max() < 1e-3


@pytest.mark.parametrize("weight", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("over", ["counting_hands", "other_hands", None])
def test_hands_of_any_weight_replace_others_without_a_jump(one: Setup, over: str | None, weight: float) -> None:
    characters, plain, bare = one(), one(), one()
    for each in (characters, plain, bare):
        each.add(1, "counting")
        each.advance()
    characters.wear([0], "counting_hands", blend=0.0)
    joints = fingers(characters.stage.bank.skeleton, characters.stage.bank.roles)

    def apart(some: Characters, others: Characters) -> float:
        return float(quaternion.angle(rotations_of(some)[0][joints], rotations_of(others)[0][joints]).max())

    while apart(characters, bare) < 1.2:  # until a finger is bent
        for each in (characters, plain, bare):
            each.advance()
    characters.wear([0], over, blend=0.3, weight=weight)
    plain.wear([0], over, blend=0.0, weight=weight)
    steps = []
    for _ in range(25):
        before = rotations_of(characters)[0][joints]
        for each in (characters, plain):
            each.advance()
        steps.append(quaternion.angle(rotations_of(characters)[0][joints], before).max())
    assert max(steps) < 0.25
    assert apart(characters, plain) == 0.0


def test_hands_of_weight_0_are_the_clips_own_and_of_weight_1_the_hands_clips(one: Setup) -> None:
    bare, none, whole = one(), one(), one()
    for characters in (bare, none, whole):
        characters.add(1, "walk")
        characters.act([0], Action("counting", blend=0.0))
    none.wear([0], "counting_hands", blend=0.0, weight=0.0)
    whole.wear([0], "counting_hands", blend=0.0)
    bank = whole.stage.bank
    for _ in range(60):
        np.testing.assert_array_equal(rotations_of(none), rotations_of(bare))
        frame = whole.state[0, col.FIRST_ACTION + col.FRAME]
        laid = naive.rotation_between(bank.hand_motion("counting_hands", "counting"), frame)
        joints = list(bank.layout.hands.joints)
        assert quaternion.angle(rotations_of(whole)[0][joints], laid).max() < 1e-5
        for characters in (bare, none, whole):
            characters.advance()


def test_hands_fade_in_over_others_and_out_and_a_third_waits(one: Setup) -> None:
    characters = one()
    characters.add(1, "counting")
    own = rotations_of(characters)
    characters.wear([0], "counting_hands", blend=0.2)
    characters.wear([0], "other_hands", blend=0.2)
    np.testing.assert_allclose(rotations_of(characters), own, atol=1e-6)
    assert characters.state[0, col.HANDS] == 2
    characters.wear([0], None, blend=0.2)
    assert characters.state[0, [col.HANDS, col.HANDS_WAIT]].tolist() == [2, 1]
    for _ in range(14):
        characters.advance()
    assert characters.state[0, [col.HANDS, col.HANDS_WAIT]].tolist() == [2, 0]
    for _ in range(14):
        characters.advance()
    assert characters.state[0, col.HANDS] == 0


@pytest.mark.parametrize("over", ["other_hands", None])
def test_hands_of_low_weight_replace_others_without_a_jump(one: Setup, over: str | None) -> None:
    characters, wanted = one(), one()
    for some in (characters, wanted):
        some.add(1, "counting", time=1.7)  # in the middle of a gesture
        some.speed([0], 0.0)
    characters.wear([0], "counting_hands", blend=0.0)
    characters.wear([0], over, blend=0.5, weight=0.3)
    wanted.wear([0], over, blend=0.0, weight=0.3)
    steps, before = [], rotations_of(characters)
    distance = quaternion.angle(before, rotations_of(wanted)).max()
    for _ in range(31):
        characters.advance()
        now = rotations_of(characters)
        steps.append(quaternion.angle(now, before).max())
        before = now
    assert max(steps) < 0.1 * distance
    assert characters.state[0, col.HANDS] == (0 if over is None else 1)
    np.testing.assert_allclose(rotations_of(characters), rotations_of(wanted), atol=1e-6)


def test_hands_have_no_effect_on_clips_they_are_not_aligned_to(one: Setup) -> None:
    bare, worn = one(), one()
    for characters in (bare, worn):
        characters.add(1, "walk")
    worn.wear([0], "counting_hands", blend=0.0)
    np.testing.assert_array_equal(rotations_of(worn), rotations_of(bare))


def test_the_same_commands_give_the_same_bytes(one: Setup) -> None:
    many, alone = one(), one()
    many.add(20, "run")
    many.wear(range(20), "counting_hands", blend=0.3)
    for _ in range(9):
        many.advance()
    alone = Characters(many.stage, RATE, many.state[[7]].copy())
    for _ in range(30):
        assert rotations_of(many)[7].tobytes() == rotations_of(alone)[0].tobytes()
        many.advance()
        alone.advance()


def test_characters_keep_their_hands_on_another_bank(one: Setup, hands_bank: Bank, bank: Bank) -> None:
    characters = one()
    characters.add(2, "counting")
    characters.wear([1], "other_hands", blend=0.0)
    assert characters.missing_clips(bank) == {"counting", "other_hands"}
    assert not characters.missing_clips(hands_bank)
    moved = characters.moved(Stage(Evaluator(hands_bank)))
    np.testing.assert_array_equal(rotations_of(moved), rotations_of(characters))


@pytest.mark.parametrize(
    ("do", "error", "words"),
    [
        (lambda one: one.wear([0], "counting_hand"), UnknownClipError, "'counting_hands'"),
        (lambda one: one.wear([0], "other_hands", blend=-1.0), SettingsError, "blend -1.0"),
        (lambda one: one.wear([0], "other_hands", weight=2.0), SettingsError, "weight 2.0"),
    ],
)
def test_an_invalid_command_changes_nothing(one: Setup, do: Any, error: Any, words: str) -> None:
    characters = one()
    characters.add(1, "walk")
    before = characters.state.copy()
    with pytest.raises(error, match=words):
        do(characters)
    np.testing.assert_array_equal(characters.state, before)


def test_requests_for_unaligned_or_unknown_hands_are_refused(hands_bank: Bank, bank: Bank) -> None:
    evaluator = Evaluator(hands_bank)
    with pytest.raises(UnknownClipError, match=r"not aligned to clip 'wave'. They are aligned to 'counting', 'run'"):
        evaluator.pose(Splice("walk", "wave", hands="counting_hands"), 0.0)
    with pytest.raises(UnknownClipError, match="no hands 'wave'"):
        evaluator.pose(Splice("walk", hands="wave"), 0.0)
    with pytest.raises(UnknownClipError, match="--hands BODY:HANDS"):
        Evaluator(bank).pose(Splice("walk", hands="counting_hands"), 0.0)
    requests = Requests.empty(3)
    requests.action[:] = hands_bank.number("wave")
    for number, words in ((9, "hands number 9 lies outside 0 to 2"), (1, "not aligned")):
        requests.hands[:] = 0
        requests.hands[2] = number
        with pytest.raises(SettingsError, match=f"character 2: .*{words}"):
            evaluator.evaluate(requests, evaluator.poses(3))
    requests.hands[:] = 0
    requests.time[1] = -1.0
    with pytest.raises(TimeRangeError) as raised:
        evaluator.evaluate(requests, evaluator.poses(3))
    assert isinstance(raised.value, MotionError)
