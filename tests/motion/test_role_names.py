from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.role_names import HELPERS, KNOWN, LIMB_WORDS, roles_by_name, words_of
from tests import rig_names
from tests.more_rig_names import MORE_RIGS

RIGS = rig_names.RIGS | MORE_RIGS
NAMES_IN_WORDS = KNOWN | HELPERS | {*LIMB_WORDS}


@pytest.mark.parametrize("name", RIGS)
def test_the_roles_of_a_rig_are_found_among_all_its_joints(name: str) -> None:
    names = RIGS[name].names()
    assert {role: names[joint] for role, joint in roles_by_name(names).items()} == RIGS[name].expected()


def test_a_collar_is_not_taken_for_an_arm_whose_name_is_unknown() -> None:
    names = tuple(name.replace("LeftArm", "Alpha") for name in RIGS["HumanIK"].names())
    found = roles_by_name(names)
    assert "left_shoulder" not in found
    assert names[found["right_shoulder"]] == "RightArm"


def test_numbers_of_all_joints_are_not_those_of_limbs() -> None:
    names = ("LeftUpLeg_01", "LeftLeg_02", "LeftArm_01", "LeftForeArm_02", "RightUpLeg_3", "RightLeg_4")
    found = {role: names[joint] for role, joint in roles_by_name(names).items()}
    assert found["left_knee"] == "LeftLeg_02"
    assert found["left_shoulder"] == "LeftArm_01"
    assert found["right_knee"] == "RightLeg_4"
    names = ("LeftUpLeg", "LeftLeg", "LeftLeg1", "LeftArm2", "LeftArm", "LeftForeArm")
    assert roles_by_name(names) == {"left_hip": 0, "left_knee": 1, "left_shoulder": 4, "left_elbow": 5}


def test_names_that_say_nothing_give_no_roles() -> None:
    assert roles_by_name(()) == {}
    assert roles_by_name(("Bone", "Bone.001", "Bone.002", "左", "_", "")) == {}


@given(st.lists(st.text(max_size=12), max_size=30))
def test_any_names_are_answered(names: list[str]) -> None:
    assert all(0 <= joint < len(names) for joint in roles_by_name(tuple(names)).values())


@given(
    st.sampled_from(sorted(RIGS)),
    st.from_regex(r"([A-Z][a-z]{3,8}|[0-9]{1,3})[_.: -]", fullmatch=True),
    st.from_regex(r"([_.]([A-Z]?[a-z]{3,8}|[0-9]{1,3}))?", fullmatch=True),
)
def test_words_that_all_joints_share_do_not_matter(name: str, before: str, after: str) -> None:
    names = RIGS[name].names()
    if NAMES_IN_WORDS.intersection(words_of(before + after)[0]):
        return
    worded = tuple(f"{before}{name}{after}" for name in names)
    assert roles_by_name(worded) == roles_by_name(names)


@pytest.mark.parametrize("name", ["arm " * 100_000, "_a" * 100_000, "[" * 100_000, "L" * 100_000])
def test_a_name_of_any_length_takes_no_time(name: str) -> None:
    assert roles_by_name((name,)) == {}
