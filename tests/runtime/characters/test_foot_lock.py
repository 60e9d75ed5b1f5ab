"""The foot lock: holds of standing feet, and legs that are bent to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bench.characters.feet import stances
from motionsplice.motion import quaternion
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.legs import legs_of
from tests.naive_feet import bent, hold, played
from tests.playing import RATE, Setup, evaluated, run_frames

HOLDS = [slice(col.HOLDS + col.HOLD_COLUMNS * foot, col.HOLDS + col.HOLD_COLUMNS * (foot + 1)) for foot in (0, 1)]
lengths = st.lists(st.floats(-0.1, 0.1), min_size=4, max_size=4)
once = settings(
    max_examples=25, derandomize=True, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@once
@given(st.sampled_from(["walk", "run", "side_step", "stairs_up"]), st.floats(0.0, 2.0), lengths, st.floats(-3.0, 3.0))
def test_a_locked_pose_is_that_of_the_twin(
    bank: Bank, one: Setup, name: str, time: float, offsets: list[float], heading: float
) -> None:
    characters = one()
    characters.add(1, name, time=time)
    characters.act([0], Action("wave", blend=0.0))
    characters.place([0], [1.0, 0.0, 2.0], heading)
    roots, free = (array[0] for array in evaluated(characters))
    lock(characters.state[0], offsets)
    locked = evaluated(characters)[1][0]
    x, z = np.reshape(offsets, (2, 2)).T
    turned = [np.cos(heading) * x + np.sin(heading) * z, np.cos(heading) * z - np.sin(heading) * x]
    wanted = bent(bank, roots, free, np.transpose(turned))
    assert quaternion.angle(locked, wanted).max() < 1e-3  # a nearly straight knee magnifies what float32 rounds
    np.testing.assert_allclose(world(bank, roots, locked), world(bank, roots, wanted), rtol=0.0, atol=2e-5)


@once
@given(st.floats(0.0, 2.0), lengths)
def test_a_lock_turns_legs_only_and_keeps_the_orientation_of_feet(
    bank: Bank, one: Setup, time: float, offsets: list[float]
) -> None:
    characters, roles = one(), bank.roles
    characters.add(1, "run", time=time)
    roots, free = (array[0] for array in evaluated(characters))
    lock(characters.state[0], offsets)
    locked = evaluated(characters)[1][0]
    legs = [getattr(roles, f"{side}_{joint}") for side in ("left", "right") for joint in ("hip", "knee", "ankle")]
    others = np.setdiff1d(np.arange(bank.skeleton.joint_count), legs)
    np.testing.assert_array_equal(locked[others], free[others])
    before, after = (world_transforms(bank.skeleton, roots[None], one[None]) for one in (free, locked))
    feet = [joint for side in roles.feet for joint in side]
    assert quaternion.angle(before[1][0, feet], after[1][0, feet]).max() < 2e-3
    for side, (x, z) in zip(("left", "right"), np.reshape(offsets, (2, 2)), strict=True):
        hip, ankle = getattr(roles, f"{side}_hip"), getattr(roles, f"{side}_ankle")
        aim = before[0][0, ankle] + [x, 0.0, z] - after[0][0, hip]
        leg = after[0][0, ankle] - after[0][0, hip]
        assert np.linalg.norm(np.cross(quaternion.unit(aim), quaternion.unit(leg))) < 1e-5  # it points to its target
        old = float(np.linalg.norm(before[0][0, ankle] - before[0][0, hip]))
        least, most = sorted((old, float(np.linalg.norm(aim))))
        assert least - 1e-5 < np.linalg.norm(leg) < most + 1e-5


def test_a_lock_without_offsets_changes_no_bit(one: Setup) -> None:
    characters = one()
    characters.add(1, "walk", time=0.3)
    roots, free = evaluated(characters)
    lock(characters.state[0], [0.0] * 4)
    for before, after in zip((roots, free), evaluated(characters), strict=True):
        np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize("second", ["run", "turn_180~mirror"])
def test_the_holds_of_feet_are_those_of_the_twin(bank: Bank, one: Setup, second: str) -> None:
    characters = one()
    characters.add(1, "walk", time=0.2)
    characters.lock_feet([0])
    run_frames(characters, 20)
    characters.play([0], second, blend=0.3)
    largest = 0.0
    for _ in range(30):
        before = characters.state[0].copy()
        characters.advance()
        after, (x, _, z, turn) = characters.state[0], characters.deltas[0]
        old, new = played(bank, before), played(bank, after)
        for foot, at in enumerate(HOLDS):
            there = sum(one.share * one.feet[foot] for one in old.values())
            here = sum(one.share * one.feet[foot] for one in new.values())
            moved = quaternion.rotate(quaternion.about([0.0, 1.0, 0.0], turn), here) + np.array([x, 0.0, z]) - there
            support = sum(
                one.share * (one.support[foot] + (old[clip].support[foot] if clip in old else 0.0)) / 2.0
                for clip, one in new.items()
            )
            wanted = hold(before[at], moved[[0, 2]], turn, support, 1.0 / RATE, characters.stage.arrays.legs.reach)
            np.testing.assert_allclose(after[at], wanted, rtol=0.0, atol=1e-5)
            largest = max(largest, float(np.hypot(*wanted[:2])))
    assert largest > 0.005


def test_locked_feet_hardly_slide(one: Setup) -> None:
    slides = []
    for locks in (True, False):
        characters = one()
        for time in np.linspace(0.0, 1.0, 8, endpoint=False):
            characters.add(1, "walk", time=time)
        characters.lock_feet(slice(None), locks)

        def change(frame: int, characters: Characters = characters) -> None:
            if frame == 30:
                characters.play(slice(None), "run")

        slides.append(np.median([one.slide for one in stances(characters, 80, change)]))
    assert slides[0] < 0.6 * slides[1]


def test_a_lock_that_is_turned_off_fades_out_and_is_forgotten(one: Setup) -> None:
    characters = one()
    characters.add(1, "walk")
    characters.lock_feet([0])
    run_frames(characters, 40)
    assert characters.state[0, col.LOCKED] == 1.0
    assert characters.state[0, col.HOLDS : col.FIRST_AIM].any()
    characters.lock_feet([0], False)
    shares = []
    for _ in range(13):
        shares.append(characters.state[0, col.LOCKED])
        characters.advance()
    assert np.all(np.diff(shares) < 0.0)
    assert not characters.state[0, [col.LOCK, col.LOCKED]].any()
    assert not characters.state[0, col.HOLDS : col.FIRST_AIM].any()


def test_a_foot_that_stands_for_long_is_let_go(one: Setup) -> None:
    """A clip that does not move: its feet stand from beginning to end."""
    characters = one()
    characters.add(1, "walk", time=0.5)
    characters.speed([0], 0.0)
    lock(characters.state[0], [0.03, 0.0, 0.03, 0.0])
    sizes = []
    for _ in range(360):
        characters.advance()
        sizes.append(np.abs(characters.state[0, col.HOLDS : col.FIRST_AIM].reshape(2, 3)[:, 0]).max())
    assert sizes[50] == pytest.approx(0.03, abs=1e-3)
    assert sizes[-1] < 1e-3
    assert -np.diff(sizes).max() < 0.06 / RATE


def test_a_rig_without_legs_is_refused(one: Setup, bank: Bank) -> None:
    characters = one()
    characters.add(1, "walk")
    legs, kept = legs_of(bank.skeleton, replace(bank.roles, left_knee=0)), characters.stage.arrays
    characters.stage.arrays = kept._replace(legs=legs)
    try:
        characters.lock_feet([0], False)
        with pytest.raises(SettingsError, match="hip, knee and ankle"):
            characters.lock_feet([0])
    finally:
        characters.stage.arrays = kept


def lock(row: Floats, offsets: list[float]) -> None:
    """Locks the feet of a character at offsets: left x and z, right x and z."""
    row[[col.LOCK, col.LOCKED]] = 1.0
    for at, (x, z) in zip(HOLDS, np.reshape(offsets, (2, 2)), strict=True):
        row[at] = x, z, 0.0


def world(bank: Bank, root: Floats, rotations: Floats) -> Floats:
    return world_transforms(bank.skeleton, root[None], rotations[None])[0][0]
