"""Identities that hold for every splice, checked through the public names alone.

A clip on itself is the clip. A clip on a copy of itself that plays unevenly is the copy. The local axes of a rig do not
matter. An error in alignment or posture breaks one of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice import (
    Action,
    Aim,
    Bank,
    Characters,
    Clip,
    Evaluator,
    HandSettings,
    Look,
    Poses,
    Splice,
    Stage,
    build_bank,
    dump_bvh,
    find_roles,
    splice_exact,
    splice_hands,
)
from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.parts import MASKS
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.procedural.variants import warped
from motionsplice.motion.quaternion import Floats
from tests.conftest import CLIPS
from tests.rigs import with_bind_pose

RATE = 60.0
WALK, RUN, BOX = CLIPS["walk"], CLIPS["run"], CLIPS["carry_box"]
ROLES = find_roles(WALK.skeleton)
KEEPS: Any = st.sampled_from(["relative", "absolute", "off"])  # `running` follows the frames so far, so it drifts


def world(evaluator: Evaluator, poses: Poses) -> Floats:
    """Returns the world positions of all joints [n, J, 3], metres."""
    places = np.empty((*poses.rotations.shape[:2], 3), np.float32)
    evaluator.world_positions(poses, places)
    return places.astype(np.float64)


def built(clips: Mapping[str, Clip], folder: Path) -> Bank:
    folder.mkdir()
    for name, clip in clips.items():
        (folder / f"{name}.bvh").write_bytes(dump_bvh(clip))
    (folder / "clips.toml").write_text('[box]\nkind = "action"\nneutral = "walk"' if "box" in clips else "")
    assert not build_bank([folder], folder / "bank", baseline="walk", jobs=1).failed
    return Bank.open(folder / "bank")


@given(st.data(), KEEPS)
@settings(max_examples=40)
def test_a_clip_on_itself_is_the_clip(bank: Bank, data: st.DataObject, posture: Any) -> None:
    evaluator, clip = Evaluator(bank), data.draw(st.sampled_from(bank.numbered))
    times = np.sort(data.draw(st.lists(st.floats(0.0, clip.duration), min_size=1, max_size=5)))
    spliced, alone = (
        world(evaluator, evaluator.sequence(one, times))
        for one in (Splice(clip.name, clip.name, posture=posture), Splice(clip.name))
    )
    assert np.abs(spliced - alone).max() < 1e-3


@given(st.data(), KEEPS, st.sampled_from(sorted(MASKS)), st.floats(0.0, 1.0), st.integers(0, 400))
@settings(max_examples=40)
def test_an_action_that_is_the_characters_locomotion_changes_nothing(
    bank: Bank, data: st.DataObject, posture: Any, mask: Any, weight: float, frames: int
) -> None:
    name, method = data.draw(st.sampled_from(bank.numbered)).name, data.draw(st.sampled_from(["splice", "naive"]))
    characters = Characters(Stage(Evaluator(bank)), RATE)
    characters.add(2, name)
    action: Any = {"mask": mask, "weight": weight, "posture": posture, "method": method}
    characters.act([1], Action(name, blend=data.draw(st.sampled_from([0.0, 0.5])), **action))
    for _ in range(frames if method == "splice" else frames % 100):  # a naive action has no seam
        characters.advance()
    poses = characters.stage.evaluator.poses(2)
    characters.evaluate(poses)
    alone, acting = world(characters.stage.evaluator, poses)
    assert np.abs(acting - alone).max() < 2e-3


@given(
    st.integers(0, 1000),
    st.sampled_from(["left", "right", "both", "each"]),
    st.booleans(),
    st.sampled_from(["window", "trunk"]),
)
@settings(max_examples=10)
def test_a_performers_hands_on_the_same_performance_change_nothing(
    seed: int, hand: Any, wrist: bool, turn: Any
) -> None:
    clip = gesture_pair(seed, gestures=3, seconds=2.5).hands
    roles = find_roles(clip.skeleton)
    found = splice_hands(clip, roles, clip, roles, HandSettings(hand, wrist=wrist, turn=turn))
    np.testing.assert_allclose(joint_positions(found.clip), joint_positions(clip), atol=1e-6)
    assert found.mismatch == 0.0


def uneven(frame_count: int, swing: float, ripple: float) -> Floats:
    """Returns real-valued frames that play a whole clip unevenly, at 0.4 to 1.6 times its speed."""
    part = np.linspace(0.0, 1.0, frame_count)
    curve = part + swing * np.sin(2.0 * np.pi * part) + ripple * np.sin(6.0 * np.pi * part)
    return np.asarray(curve * (frame_count - 1))


swings, ripples = st.floats(-0.05, 0.05), st.floats(-0.015, 0.015)


@given(st.sampled_from(["walk", "run", "carry_box"]), swings, ripples)
@settings(max_examples=8)
def test_a_clip_on_an_uneven_copy_of_itself_gives_the_unevenness(name: str, swing: float, ripple: float) -> None:
    clip = CLIPS[name]
    frames = uneven(clip.frame_count, swing, ripple)
    found = splice_exact(warped(clip, frames, "uneven"), clip, ROLES).action_frames
    apart = np.abs(found - frames[: len(found)]) * 30.0 / clip.rate
    assert np.median(apart) < 0.5
    assert np.percentile(apart, 95) < 2.0


@pytest.mark.parametrize(("swing", "ripple"), [(0.05, -0.01), (-0.04, 0.015)])
def test_a_clip_of_a_bank_on_an_uneven_copy_of_itself_is_the_copy(swing: float, ripple: float, tmp_path: Path) -> None:
    copy = warped(WALK, uneven(WALK.frame_count, swing, ripple), "uneven")
    evaluator = Evaluator(built({"walk": WALK, "uneven": copy}, tmp_path / "clips"))
    times = evaluator.frame_times("uneven")
    spliced, alone, naive = (
        world(evaluator, evaluator.sequence(Splice("uneven", "walk", method=method), times))
        for method in ("splice", "none", "naive")
    )
    apart, far = (np.linalg.norm(one - alone, axis=2) for one in (spliced, naive))
    assert np.percentile(apart, 95) < 0.02
    assert apart.mean() < 0.25 * far.mean()


@pytest.mark.parametrize("seed", [1, 2])
def test_local_axes_do_not_matter(seed: int, tmp_path: Path) -> None:
    """A file's local axes are those of the world in its bind pose, so another bind pose gives others.

    A posture transfer that is applied in the pelvis's own axes is 5 cm off here (docs/method.md).
    """
    draw = np.random.default_rng(seed)
    turns = {
        name: quaternion.about(quaternion.unit(draw.normal(size=3)), draw.uniform(0.0, 0.6))
        for name in WALK.skeleton.names
    }
    clips = {"walk": WALK, "run": RUN, "box": BOX}
    plain = Evaluator(built(clips, tmp_path / "plain"))
    turned = Evaluator(built({name: with_bind_pose(one, turns) for name, one in clips.items()}, tmp_path / "turned"))
    assert np.abs(plain.bank.skeleton.offsets - turned.bank.skeleton.offsets).max() > 0.02
    times: Any = np.linspace(0.0, plain.bank.clip("run").duration, 7)
    forms: list[Any] = [{"posture": "relative"}, {"posture": "absolute"}, {"posture": "off"}, {"method": "naive"}]
    for form in forms:
        ours, theirs = (world(one, one.sequence(Splice("run", "box", **form), times)) for one in (plain, turned))
        np.testing.assert_allclose(theirs, ours, atol=1e-4, err_msg=str(form))
    ours, theirs = (played(one) for one in (plain, turned))
    np.testing.assert_allclose(theirs, ours, atol=1e-4)


def played(evaluator: Evaluator) -> Floats:
    """Returns the world positions of characters that mix locomotions, act with parts of the body, look and aim."""
    characters = Characters(Stage(evaluator), RATE)
    characters.add(6, {"walk": 0.6, "run": 0.4})
    for row, mask in enumerate(sorted(MASKS)):
        characters.act([row], Action("box", mask=mask, weight=0.8))  # type: ignore[arg-type]
    characters.act([5], Action("box", method="naive"))
    characters.lock_feet([0, 1])
    characters.look([1, 2], Look((2.0, 1.0, 4.0)))
    characters.aim([3], Aim((1.0, 1.5, 3.0), part="left_arm"))
    characters.aim([4], Aim((-1.0, 1.0, 3.0), steady=1.0))
    poses = evaluator.poses(len(characters))
    for _ in range(45):
        characters.advance()
        characters.evaluate(poses)
    return world(evaluator, poses)
