"""Rigs that are no human bodies."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from motionsplice.motion.errors import RoleError
from motionsplice.motion.roles import find_roles
from tests.motion.test_roles import RIGS, rig

ANIMALS: Mapping[str, tuple[tuple[str, ...], str]] = {
    "a dog": (
        (
            "Hips Spine Chest Neck Head",
            "Hips Tail1 Tail2",
            *(f"Chest {side}FrontLeg1 {side}FrontLeg2 {side}FrontPaw" for side in ("Left", "Right")),
            *(f"Hips {side}HindLeg1 {side}HindLeg2 {side}HindPaw" for side in ("Left", "Right")),
        ),
        r"it has 4 legs \(LeftFrontLeg1, RightFrontLeg1, LeftHindLeg1, RightHindLeg1\)",
    ),
    "Rigify's wolf": (
        (
            "spine spine.001 spine.002 spine.003",
            "spine tail.001",
            *(f"spine thigh.{side} shin.{side} foot.{side} toe.{side}" for side in "LR"),
            *(f"spine.003 front_thigh.{side} front_shin.{side} front_foot.{side}" for side in "LR"),
        ),
        r"it has 4 legs",
    ),
    "a spider": (
        tuple(f"Body Leg{number}_Upper_{side} Leg{number}_Lower_{side}" for number in range(1, 5) for side in "LR"),
        r"it has 8 legs",
    ),
    "a bird": (
        (
            "Hips Spine Neck Head",
            *(f"Spine Wing1_{side} Wing2_{side}" for side in "LR"),
            *(f"Hips UpLeg_{side} Leg_{side} Foot_{side}" for side in "LR"),
        ),
        r"it has wings in place of arms",
    ),
}


@pytest.mark.parametrize("name", ANIMALS)
def test_animals_are_refused_with_the_reason_and_no_roles_file_to_fill_in(name: str) -> None:
    chains, reason = ANIMALS[name]
    with pytest.raises(RoleError, match=f"this is not a human body: {reason}") as error:
        find_roles(rig(chains))
    assert "[roles]" not in str(error.value)


def test_a_human_with_a_tail_and_wings_is_a_human() -> None:
    assert find_roles(rig((*RIGS["LAFAN1"], "Hips Tail1 Tail2", "Spine2 LeftWing LeftWing1", "Spine2 RightWing")))


def test_targets_of_feet_are_no_legs() -> None:
    chains = (
        *(chain.replace("Arm", "Alpha") for chain in RIGS["LAFAN1"]),
        "Hips LeftFootTarget",
        "Hips FootIK LegPole",
    )
    with pytest.raises(RoleError, match="no joint found for left_elbow, right_elbow"):
        find_roles(rig(chains))
