from __future__ import annotations

import pytest

from motionsplice.motion.role_names import roles_by_name
from tests.rig_names import RIGS


@pytest.mark.parametrize("name", RIGS)
def test_the_roles_of_a_rig_are_found_among_all_its_joints(name: str) -> None:
    names = RIGS[name].names()
    assert {role: names[joint] for role, joint in roles_by_name(names).items()} == RIGS[name].expected()


def test_a_collar_is_not_taken_for_an_arm_whose_name_is_unknown() -> None:
    names = tuple(name.replace("LeftArm", "Alpha") for name in RIGS["HumanIK"].names())
    found = roles_by_name(names)
    assert "left_shoulder" not in found
    assert names[found["right_shoulder"]] == "RightArm"


def test_names_that_say_nothing_give_no_roles() -> None:
    assert roles_by_name(()) == {}
    assert roles_by_name(("Bone", "Bone.001", "Bone.002", "左", "_", "")) == {}
