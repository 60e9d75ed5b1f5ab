from __future__ import annotations

import numpy as np
import pytest

from bench.characters import aimed
from bench.characters.aim_offset import offset
from bench.characters.aimed import AHEAD, FRAMES, SETTLED, Shown, shown
from motionsplice.motion import quaternion
from motionsplice.motion.roles import common_ancestor
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters.aim import Aim
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage


@pytest.fixture(scope="module")
def stage(bank: Bank) -> Stage:
    return Stage(Evaluator(bank))


@pytest.fixture(scope="module")
def clip(stage: Stage) -> Shown:
    return shown(stage, "run", "carry_box", aimed.nothing)


def test_straight_ahead_it_changes_nothing(stage: Stage, clip: Shown) -> None:
    ahead = quaternion.rotate(quaternion.about(aimed.UP, clip.headings), AHEAD)
    found = offset(stage, clip, stage.bank.roles.head, ahead)
    np.testing.assert_allclose(found.places, clip.places, atol=1e-6)


@pytest.mark.parametrize(("yaw", "pitch"), [(0.7, 0.0), (-0.5, 0.4)])
def test_the_head_turns_by_yaw_and_pitch_and_the_legs_by_nothing(
    stage: Stage, clip: Shown, yaw: float, pitch: float
) -> None:
    local = [np.sin(yaw) * np.cos(pitch), np.sin(pitch), np.cos(yaw) * np.cos(pitch)]
    to = quaternion.rotate(quaternion.about(aimed.UP, clip.headings), local)
    found = offset(stage, clip, stage.bank.roles.head, to)
    turned = [aimed.in_heading(one, aimed.gazes(stage, one)) for one in (clip, found)]
    up_first = quaternion.rotate(quaternion.about([1.0, 0.0, 0.0], -pitch), turned[0])
    np.testing.assert_allclose(turned[1], quaternion.rotate(quaternion.about(aimed.UP, yaw), up_first), atol=1e-5)
    legs = [joint for joints in stage.bank.roles.feet for joint in joints]
    np.testing.assert_array_equal(found.places[:, legs], clip.places[:, legs])


def test_an_aimed_chest_that_is_not_steadied_turns_as_by_an_offset(stage: Stage, clip: Shown) -> None:
    """They are written independently of each other."""
    direction = (1.0, 0.0, 1.5)
    aims = shown(stage, "run", "carry_box", lambda one: one.aim([0], Aim(direction=direction), blend=0.0))
    roles = stage.bank.roles
    chest = common_ancestor(stage.bank.skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    found = offset(stage, clip, chest, np.broadcast_to(direction, (FRAMES, 3)))
    np.testing.assert_allclose(aims.places[SETTLED:], found.places[SETTLED:], atol=2e-3)
