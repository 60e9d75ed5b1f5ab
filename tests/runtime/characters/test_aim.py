"""Characters that look and aim: where they point, within which limits, and how they get there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.aim import AIM_PARTS, PARTS, Aim, Look
from motionsplice.runtime.characters.aim_kernels import way_to
from motionsplice.runtime.characters.aimed_pose_kernels import part_of_swing, swivel_of
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from tests import naive_aim
from tests.playing import RATE, Setup, evaluated, run_frames
from tests.rigs import with_bind_pose

seeds = st.integers(0, 2**32 - 1)
yaws, pitches = st.floats(-1.2, 1.2), st.floats(-0.65, 0.65)
moments = st.integers(0, 200)
once = settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
UP, FORWARD = [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
AIMS: Mapping[str, Any] = {
    "head": lambda one, blend=0.0, **values: one.look([0], Look(**values), blend=blend),
    **{
        part: lambda one, part=part, blend=0.0, **values: one.aim([0], Aim(part=part, **values), blend=blend)
        for part in AIM_PARTS
    },
}


def toward(yaw: float, pitch: float) -> Floats:
    """Returns the direction at a yaw to the left and a pitch upward."""
    return np.array([np.cos(pitch) * np.sin(yaw), np.sin(pitch), np.cos(pitch) * np.cos(yaw)])


def world_of(characters: Characters) -> tuple[Floats, Floats]:
    """Returns places [J, 3] and rotations [J, 4] in the world of the first character's joints."""
    roots, rotations = evaluated(characters)
    places, world = world_transforms(characters.stage.bank.skeleton, roots[:1], rotations[:1])
    return places[0], world[0]


def pointing(characters: Characters, part: str) -> tuple[Floats, Floats]:
    """Returns from where and which way a head or an arm of the first character points."""
    (places, world), roles = world_of(characters), characters.stage.bank.roles
    if part == "head":
        return places[roles.head], quaternion.rotate(world[roles.head], characters.stage.arrays.chains.gaze)
    ends = ("shoulder", "wrist")
    shoulder, wrist = (places[getattr(roles, part.replace("arm", end))] for end in ends)
    return shoulder, quaternion.unit(wrist - shoulder)


def degrees_apart(a: Floats, b: Floats) -> float:
    return float(np.degrees(2.0 * np.arcsin(0.5 * np.linalg.norm(quaternion.unit(a) - quaternion.unit(b)))))


def draw_target(draw: np.random.Generator) -> dict[str, Any]:
    """Draws a target at any side, near or far, or a direction, and how it is followed."""
    to = draw.normal(size=3) * draw.choice([0.3, 1.0, 10.0]) + [0.0, 1.0, 0.0]
    limits = {"max_yaw": draw.uniform(0.0, 2.6), "max_pitch": draw.uniform(0.0, 1.39)}
    shares = {"weight": draw.choice([1.0, draw.random()]), "steady": draw.choice([0.0, 1.0, draw.random()])}
    return {str(draw.choice(["point", "direction"])): tuple(to)} | limits | shares


def command_targets(characters: Characters, rows: Any, draw: np.random.Generator) -> None:
    part, blend = draw.choice(list(PARTS)), float(draw.choice([0.0, 0.1, 0.5]))
    if draw.random() < 0.15:
        characters.look(rows, None, blend=blend)
        characters.aim(rows, None, blend=blend)
    elif part == "head":
        characters.look(rows, Look(spine=draw.random(), **draw_target(draw)), blend=blend)
    else:
        characters.aim(rows, Aim(part=part, **draw_target(draw)), blend=blend)


@once
@given(seeds)
def test_turned_poses_agree_with_the_twin(one: Setup, seed: int) -> None:
    draw, characters = np.random.default_rng(seed), one()
    bank = characters.stage.bank
    for name in ("walk", "run", "turn_180"):
        characters.add(1, name, time=float(draw.uniform(0.0, 2.0)))
    characters.act([1], Action("carry_box", blend=0.0))
    for row in range(3):
        characters.place([row], draw.normal(size=3).tolist(), float(draw.normal()))
    characters.in_place([2])
    for _ in range(60):
        if draw.random() < 0.15:
            command_targets(characters, [0, 1, 2], draw)
        evaluated(characters)
        characters.advance()
    command_targets(characters, [0, 1], draw)
    before = characters.state.copy()
    characters.state[:, col.AIMED] = 0.0
    roots, bare = evaluated(characters)
    characters.state[:] = before
    rotations = evaluated(characters)[1]
    for row, state in enumerate(before):
        twin = naive_aim.aimed(bank, state, roots[row], bare[row])
        assert quaternion.angle(rotations[row], twin).max() < 1e-3
        assert np.abs(quaternion.length(rotations[row]) - 1.0).max() < 1e-6


@once
@given(moments, yaws, pitches, st.sampled_from(["head", "left_arm", "right_arm"]))
def test_a_direction_within_the_limits_is_reached(one: Setup, at: int, yaw: float, pitch: float, part: str) -> None:
    characters = one()
    characters.add(1, "run")
    characters.act([0], Action("carry_box", blend=0.0))
    characters.place([0], (3.0, 0.0, -2.0), 0.7)
    AIMS[part](characters, direction=toward(yaw + 0.7, pitch), max_yaw=1.6, max_pitch=0.9)
    characters.advance(at)
    turn = characters.state[0, col.HEADING] - 0.7
    reached = quaternion.rotate(quaternion.about(UP, -turn), pointing(characters, part)[1])
    wanted = quaternion.rotate(quaternion.about(UP, -turn), toward(yaw + 0.7, pitch))
    assert degrees_apart(reached, wanted) < 0.05


@once
@given(moments, yaws, pitches, st.floats(0.3, 30.0), st.sampled_from(["head", "left_arm", "right_arm"]))
@example(0, -1.125, -0.5, 0.5, "left_arm")  # the chest's turn brings the shoulder near it
def test_a_near_point_is_met_exactly(one: Setup, at: int, yaw: float, pitch: float, distance: float, part: str) -> None:
    characters = one()
    characters.add(1, "walk")
    characters.advance(at)
    place, heading = pointing(characters, part)[0], characters.state[0, col.HEADING]
    point = place + distance * toward(yaw + heading, pitch)
    AIMS["chest"](characters, point=point)  # moves shoulders and head, too
    AIMS[part](characters, point=point, max_yaw=2.0, max_pitch=1.3)
    place, reached = pointing(characters, part)
    left, up, ahead = quaternion.rotate(quaternion.about(UP, -heading), point - place)
    if np.linalg.norm(point - place) > 0.15 and degrees_apart(point - place, reached) > 0.05:
        assert abs(np.arctan2(up, np.hypot(left, ahead))) > 1.1 or abs(np.arctan2(left, ahead)) > 1.8  # near the limits


@once
@given(moments, yaws)
def test_steady_hands_stay_on_the_side_of_the_target(one: Setup, at: int, yaw: float) -> None:
    characters = one()
    characters.add(1, "run", time=0.3)
    characters.act([0], Action("carry_box", blend=0.0))
    AIMS["chest"](characters, direction=toward(yaw, 0.3), steady=1.0, max_yaw=1.4)
    characters.advance(at)
    (places, _), roles = world_of(characters), characters.stage.bank.roles
    hands = 0.5 * (places[roles.left_wrist] + places[roles.right_wrist]) - places[0]
    assert abs(np.degrees(np.arctan2(hands[0], hands[2]) - yaw)) < 0.05


@pytest.mark.parametrize("part", list(PARTS))
def test_weight_0_and_a_target_that_has_faded_out_change_no_bit(one: Setup, part: str) -> None:
    plain, none, ended = one(), one(), one()
    for characters in (plain, none, ended):
        characters.add(1, "run")
        characters.act([0], Action("wave", mask="right_arm"))
    AIMS[part](none, point=(1.0, 1.0, 1.0), weight=0.0)
    AIMS[part](ended, point=(1.0, 1.0, 1.0))
    for frame in range(120):
        if frame == 20:
            ended.look([0], None, blend=0.3)
            ended.aim([0], None, blend=0.3)
        bits = evaluated(plain)[1].tobytes()
        assert evaluated(none)[1].tobytes() == bits
        assert (evaluated(ended)[1].tobytes() == bits) == (ended.state[0, col.AIMED] == 0.0)
        for characters in (plain, none, ended):
            characters.advance()
    assert ended.state[0, col.AIMED] == none.state[0, col.AIMED] == 0.0


@once
@given(seeds, st.floats(-np.pi, np.pi), st.booleans())
def test_another_place_and_heading_change_nothing(one: Setup, seed: int, heading: float, in_place: bool) -> None:
    draw, here, there = np.random.default_rng(seed), one(), one()
    place, target, part = draw.normal(size=3), draw_target(draw), str(draw.choice(list(PARTS)))
    moved = dict(target)
    turn = quaternion.about(UP, heading)
    if "point" in target:
        moved["point"] = quaternion.rotate(turn, target["point"]) + place
    else:
        moved["direction"] = quaternion.rotate(turn, target["direction"])
    for characters, values in ((here, target), (there, moved)):
        characters.add(1, "run")
        AIMS[part](characters, **values)
    there.place([0], place.tolist(), heading)
    there.in_place([0], in_place)
    for _ in range(5):
        a, b = evaluated(here)[1][0], evaluated(there)[1][0]
        assert quaternion.angle(a[1:], b[1:]).max() < 2e-5
        run_frames(here, 12), run_frames(there, 12)


@pytest.mark.parametrize("part", list(PARTS))
def test_a_target_that_circles_makes_nothing_jump(one: Setup, part: str) -> None:
    """It passes behind the back; per degree of its way, no joint turns by more than four."""
    characters = one()
    characters.add(1, "walk")
    characters.speed([0], 0.0)
    before = None
    for degrees in range(0, 361, 2):
        AIMS[part](characters, direction=toward(np.radians(degrees), 0.2), weight=1.0)
        now = evaluated(characters)[1][0]
        if before is not None:
            assert np.degrees(quaternion.angle(before, now)).max() < 8.0
        before = now


@pytest.mark.parametrize("part", list(PARTS))
@pytest.mark.parametrize("aside", [2.0, 8.0, 20.0])
def test_a_target_that_passes_overhead_makes_nothing_jump(one: Setup, part: str, aside: float) -> None:
    """Per degree of its way, no joint turns by more than six."""
    characters = one()
    characters.add(1, "walk")
    characters.speed([0], 0.0)
    before = None
    for degrees in range(-40, 220):
        AIMS[part](characters, direction=np.add(toward(0.0, np.radians(degrees)), [np.tan(np.radians(aside)), 0, 0]))
        now = evaluated(characters)[1][0]
        if before is not None:
            assert np.degrees(quaternion.angle(before, now)).max() < 6.0
        before = now


@pytest.mark.parametrize("part", ["left_arm", "head"])
def test_a_point_where_the_part_itself_is_turns_it_nowhere(one: Setup, part: str) -> None:
    characters = one()
    characters.add(1, "walk")
    joint = {"left_arm": characters.stage.bank.roles.left_shoulder, "head": characters.stage.bank.roles.head}[part]
    AIMS[part](characters, point=world_of(characters)[0][joint])
    assert np.isfinite(evaluated(characters)[1]).all()


@pytest.mark.parametrize("to", [0.0, 1e-300])
def test_a_target_without_a_way_is_straight_ahead(to: float) -> None:
    slot = np.zeros(col.AIM_COLUMNS)
    slot[col.TARGET], slot[col.MOST_YAW], slot[col.MOST_PITCH] = col.POINT, 1.3, 0.85
    assert np.allclose(way_to(slot, 0, 0.0, to, 0.0, False), [0.0, 0.0, 0.0, 1.0])


@once
@given(seeds)
def test_an_arm_does_not_swing_around_when_it_points_away_from_its_target(seed: int) -> None:
    """A small movement of an arm changes its turn by a small one, also where it points the opposite way."""
    draw = np.random.default_rng(seed)
    rest, line, goal = (tuple(quaternion.unit(draw.normal(size=3))) for _ in range(3))
    if draw.random() < 0.5:
        goal = tuple(quaternion.unit(0.01 * draw.normal(size=3) - line))
    share, moved = draw.random(), tuple(quaternion.unit(1e-4 * draw.normal(size=3) + line))
    way = np.radians(degrees_apart(np.array(rest), np.array(line)))
    other_way = np.radians(degrees_apart(np.array(rest), np.array(goal)))
    if max(way, other_way) < np.radians(160.0):
        a, b = (part_of_swing(rest, one, goal, share) for one in (line, moved))
        apart = np.radians(degrees_apart(np.array(line), np.array(moved)))
        assert quaternion.angle(a, b) < 10.0 * apart
        twin = naive_aim.part_of_swing(np.array(rest), np.array(line), np.array(goal), share)
        assert quaternion.angle(a, twin) < 1e-4
        np.testing.assert_allclose(quaternion.rotate(part_of_swing(rest, line, goal, 1.0), line), goal, atol=1e-4)


@once
@given(seeds)
def test_hands_on_both_sides_of_the_chest_do_not_swing_it_around(seed: int) -> None:
    draw, ahead = np.random.default_rng(seed), (0.0, 0.0, 1.0)
    chest = tuple(draw.normal(size=3) * [0.05, 0.0, 0.05] + [0.0, 0.4, 0.0])
    left, by = 0.4 * draw.normal(size=3), 1e-5 * draw.normal(size=3)
    right = 0.1 * draw.normal(size=3) - left
    before, after = (swivel_of(tuple(left), tuple(one), chest, ahead) for one in (right, right + by))
    far = 0.5 * (np.linalg.norm(left) + np.linalg.norm(right))
    assert abs(after - before) < 15.0 * np.linalg.norm(by) / far


@pytest.mark.parametrize("part", list(PARTS))
def test_a_new_target_is_approached_smoothly(one: Setup, part: str) -> None:
    characters = one()
    characters.add(1, "walk")
    characters.speed([0], 0.0)
    turns = []
    before = world_of(characters)[1]
    for frame in range(180):
        if frame in (20, 80):
            AIMS[part](characters, direction=toward(1.2 if frame == 20 else -1.2, 0.3), blend=0.5)
        if frame == 140:
            characters.look([0], None, blend=0.5)
            characters.aim([0], None, blend=0.5)
        now = world_of(characters)[1]
        turns.append(np.degrees(quaternion.angle(before, now)).max())
        before = now
        characters.advance()
    assert max(turns[:20]) < 0.01
    assert turns[20] < 0.01  # nothing has happened yet at the frame of a command
    assert turns[80] < 0.5
    assert 1.0 < max(turns) < 30.0  # of about 140 degrees
    assert max(np.abs(np.diff(turns))) < 10.0


def test_a_target_that_is_moved_each_frame_is_followed(one: Setup) -> None:
    characters = one()
    characters.add(1, "walk")
    for frame in range(120):
        direction = toward(0.01 * frame - 0.6, 0.0)
        AIMS["head"](characters, direction=direction, blend=0.3)
        _, reached = pointing(characters, "head")
        characters.advance()
    assert degrees_apart(reached, direction) < 5.0  # 0.6 rad/s, 0.13 s late


@once
@given(seeds)
def test_the_same_targets_give_the_same_bytes_alone_among_others_and_after_a_restore(one: Setup, seed: int) -> None:
    draw, together = np.random.default_rng(seed), one()
    together.add(20, "walk")
    for _ in range(40):
        command_targets(together, draw.integers(20, size=3), draw)
        evaluated(together)
        together.advance()
    row = int(draw.integers(20))
    alone = Characters(together.stage, RATE, together.state[[row]].copy())
    twice = Characters(together.stage, RATE, np.frombuffer(together.state.tobytes()).reshape(20, -1).copy())
    for _ in range(30):
        rotations = evaluated(together)[1]
        assert rotations[row].tobytes() == evaluated(alone)[1][0].tobytes()
        assert rotations.tobytes() == evaluated(twice)[1].tobytes()
        assert rotations.tobytes() == evaluated(together)[1].tobytes()
        for characters in (together, alone, twice):
            characters.advance()
    assert together.state.tobytes() == twice.state.tobytes()


def bank_with(clip: Clip, folder: Path) -> Stage:
    (folder / "walk.bvh").write_bytes(dump_bvh(clip))
    build_bank([folder / "walk.bvh"], folder / "bank", baseline="walk", jobs=1)
    return Stage(Evaluator(Bank.open(folder / "bank")))


def test_local_axes_and_bind_poses_do_not_matter(tmp_path_factory: pytest.TempPathFactory) -> None:
    clip, draw = make("walk", seed=1, seconds=3.0), np.random.default_rng(0)
    upper = [name for name in clip.skeleton.names if not any(part in name for part in ("Hips", "Leg", "Foot", "Toe"))]
    turns = {name: quaternion.about(quaternion.unit(draw.normal(size=3)), 0.4) for name in upper}
    plain, other = (
        Characters(bank_with(one, tmp_path_factory.mktemp("axes")), RATE) for one in (clip, with_bind_pose(clip, turns))
    )
    for characters in (plain, other):
        characters.add(1, "walk")
        characters.advance(20)
        AIMS["chest"](characters, point=(2.0, 1.0, 3.0), steady=1.0)
        AIMS["left_arm"](characters, direction=(1.0, 0.5, 1.0))
        AIMS["head"](characters, point=(-1.0, 2.0, 3.0))
    np.testing.assert_allclose(world_of(plain)[0], world_of(other)[0], atol=2e-4)


@pytest.mark.parametrize("missing", [("Head",), ("Head", "Neck")])
def test_a_rig_without_head_or_neck_looks_with_what_it_has(missing: tuple[str, ...], tmp_path: Path) -> None:
    clip = make("walk", seed=1, seconds=3.0)
    keep = [joint for joint, name in enumerate(clip.skeleton.names) if name not in missing]
    parents = np.array([keep.index(parent) if parent in keep else -1 for parent in clip.skeleton.parents[keep]])
    ends = np.array([end for end, joint in enumerate(clip.skeleton.end_parents) if joint in keep])
    skeleton = Skeleton(
        tuple(clip.skeleton.names[joint] for joint in keep),
        parents,
        clip.skeleton.offsets[keep],
        np.array([keep.index(joint) for joint in clip.skeleton.end_parents[ends]]),
        clip.skeleton.end_offsets[ends],
    )
    stage = bank_with(replace(clip, skeleton=skeleton, rotations=clip.rotations[:, keep]), tmp_path)
    characters = Characters(stage, RATE)
    characters.add(1, "walk")
    before = world_of(characters)[1]
    AIMS["head"](characters, direction=toward(0.8, 0.0))
    after = world_of(characters)[1]
    last = stage.bank.skeleton.index("Neck" if "Neck" in stage.bank.skeleton.names else "Spine2")
    turn = quaternion.multiply(after[last], quaternion.conjugate(before[last]))
    assert np.degrees(quaternion.log(turn)[1]) == pytest.approx(np.degrees(0.8), abs=12.0)


def test_targets_go_on_in_another_bank(one: Setup, hands_bank: Bank) -> None:
    characters = one()
    characters.add(1, "walk")
    characters.look([0], Look((1.0, 1.5, 8.0)))
    run_frames(characters, 60)
    moved = characters.moved(Stage(Evaluator(hands_bank)))
    place, gaze = pointing(moved, "head")
    assert degrees_apart(gaze, np.array([1.0, 1.5, 8.0]) - place) < 0.05


@pytest.mark.parametrize(
    ("do", "words"),
    [
        (lambda one: one.look([0], Look()), "a point or a direction"),
        (lambda one: one.look([0], Look((0, 0, 1), direction=(0, 0, 1))), "a point or a direction"),
        (lambda one: one.look([0], Look((0, np.nan, 1))), "point"),
        (lambda one: one.look([0], Look((0, 1e300, 1))), "point"),
        (lambda one: one.look([0], Look((0, 1))), "point"),
        (lambda one: one.look([0], Look(direction=(0, np.inf, 1))), "direction"),
        (lambda one: one.aim([0], Aim(direction=(0, 0, 0))), "zero"),
        (lambda one: one.aim([0], Aim((0, 0, 1), part="leg")), "part"),  # type: ignore[arg-type]
        (lambda one: one.aim([0], Aim((0, 0, 1), weight=1.5)), "weight"),
        (lambda one: one.aim([0], Aim((0, 0, 1), steady=np.nan)), "steady"),
        (lambda one: one.look([0], Look((0, 0, 1), spine=-0.1)), "spine"),
        (lambda one: one.look([0], Look((0, 0, 1), max_yaw=3.2)), "max_yaw"),
        (lambda one: one.look([0], Look((0, 0, 1), max_pitch=1.5)), "max_pitch"),
        (lambda one: one.look([0], Look((0, 0, 1)), blend=-1.0), "blend"),
        (lambda one: one.look([0], None, blend=np.nan), "blend"),
    ],
)
def test_an_invalid_target_changes_nothing(one: Setup, do: Callable[[Characters], None], words: str) -> None:
    characters = one()
    characters.add(1, "walk")
    before = characters.state.tobytes()
    with pytest.raises(SettingsError, match=words):
        do(characters)
    assert characters.state.tobytes() == before


@pytest.mark.parametrize("direction", [(1e-300, 0.0, 1e-300), (1e300, 0.0, 1e300), (3, 0, 3)])
def test_the_length_of_a_direction_does_not_matter(one: Setup, direction: tuple[float, float, float]) -> None:
    characters = one()
    characters.add(1, "walk")
    AIMS["head"](characters, direction=direction)
    assert degrees_apart(pointing(characters, "head")[1], np.array([1.0, 0.0, 1.0])) < 0.05


@pytest.mark.parametrize(("part", "joint"), [("chest", "Spine2"), ("left_arm", "LeftArm"), ("head", "Head")])
def test_nothing_jumps_when_a_far_target_replaces_a_near_one(one: Setup, part: str, joint: str) -> None:
    characters = one()
    characters.add(1, "walk")
    characters.speed([0], 0.0)
    AIMS[part](characters, point=(0.3, 1.2, 0.5))
    run_frames(characters, 5)
    at = characters.stage.bank.skeleton.index(joint)
    before = world_of(characters)[1][at]
    AIMS[part](characters, point=(-20.0, 3.0, 30.0), blend=0.5)
    assert np.degrees(quaternion.angle(before, world_of(characters)[1][at])) < 0.05
