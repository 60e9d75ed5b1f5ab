from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.errors import MotionError, SettingsError, TimeRangeError, UnknownClipError
from motionsplice.motion.kinematics import joint_positions
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import POSTURES, REQUEST, Memory, Poses, Requests
from motionsplice.runtime.splice import Splice


def test_a_self_splice_is_the_clip_within_a_millimetre(bank: Bank) -> None:
    for clip in bank.clips:
        result = Evaluator(bank).clip(Splice(clip.name, clip.name))
        apart = joint_positions(result) - joint_positions(bank.motion(clip.name))
        assert np.linalg.norm(apart, axis=-1).max() < 1e-3, clip.name


def test_both_halves_keep_their_rotations(bank: Bank) -> None:
    evaluator, pelvis = Evaluator(bank), bank.roles.pelvis
    upper = [joint for joint in bank.skeleton.subtree(pelvis) if joint != pelvis]
    lower = [joint for joint in range(bank.skeleton.joint_count) if joint not in bank.skeleton.subtree(pelvis)]
    splice, walk, box = evaluator.clip(Splice("walk", "carry_box")), bank.motion("walk"), bank.motion("carry_box")
    np.testing.assert_allclose(splice.root_positions, walk.root_positions, atol=1e-6)
    assert quaternion.angle(splice.rotations, walk.rotations)[:, lower].max() < 1e-6
    for frame in range(0, splice.frame_count, 17):
        apart = quaternion.angle(splice.rotations[frame, upper], box.rotations[:, upper]).max(axis=1)
        assert apart.min() < 0.05  # the whole upper body is from one moment between two frames


def test_method_none_is_the_locomotion_alone(bank: Bank) -> None:
    alone = Evaluator(bank).clip(Splice("run"))
    assert quaternion.angle(alone.rotations, bank.motion("run").rotations).max() < 1e-6
    none = Evaluator(bank).clip(Splice("run", "wave", method="none"))
    np.testing.assert_array_equal(none.rotations, alone.rotations)


def test_a_pose_does_not_depend_on_what_was_asked_before(bank: Bank) -> None:
    splices = [Splice("walk", "wave")]
    changes: tuple[dict[str, Any], ...] = (
        {"locomotion": "run"},
        {"action": "carry_box"},
        {"start": 0.5},
        {"method": "naive"},
        {"posture": "off"},
    )
    splices += [replace(splices[0], **change) for change in (*changes, {"action": None})]
    evaluator, other = Evaluator(bank), Evaluator(bank)
    for before, splice in pairwise([splices[0], *splices, *reversed(splices)]):
        evaluator.pose(before, 0.5)
        found = evaluator.pose(replace(splice), 0.5)
        np.testing.assert_array_equal(found.rotations, other.sequence(splice, [0.5]).rotations)


def test_an_action_shorter_than_the_locomotion_loops_in_step(bank: Bank) -> None:
    walk, wave = bank.clip("walk"), bank.clip("wave")
    assert wave.duration < walk.duration
    late = walk.duration - 0.1
    poses = Evaluator(bank).pose(Splice("walk", "wave"), late)
    upper = [joint for joint in bank.skeleton.subtree(bank.roles.pelvis) if joint != bank.roles.pelvis]
    apart = quaternion.angle(bank.motion("wave").rotations[:, upper], poses.rotations[0, upper]).max(axis=1)
    frame = int(np.argmin(apart))
    phase_u = bank.tables["phase_of_frame"][wave.first_row + frame]
    phase_l = bank.tables["phase_of_frame"][walk.first_row + round(late * walk.rate)]
    assert abs((phase_u - phase_l + 0.5) % 1.0 - 0.5) < 0.05


def test_an_action_begins_at_the_first_frame_in_step_after_start(bank: Bank) -> None:
    evaluator, wave, walk = Evaluator(bank), bank.clip("wave"), bank.clip("walk")
    upper = [joint for joint in bank.skeleton.subtree(bank.roles.pelvis) if joint != bank.roles.pelvis]
    rows = slice(wave.first_row, wave.first_row + wave.frame_count)
    phase = bank.tables["phase_of_frame"][rows]
    for start in (0.0, 0.4, 0.9):
        poses = evaluator.pose(Splice("walk", "wave", start=start), 0.0)
        apart = quaternion.angle(bank.motion("wave").rotations[:, upper], poses.rotations[0, upper]).max(axis=1)
        frame = int(np.argmin(apart))
        assert frame / wave.rate >= start - 1.0 / wave.rate
        assert phase[frame] - np.interp(start * wave.rate, np.arange(len(phase)), phase) < 1.05
        assert abs((phase[frame] - walk.first_phase + 0.5) % 1.0 - 0.5) < 0.03


@pytest.mark.parametrize("time", [-0.1, 99.0, np.nan, np.inf])
@pytest.mark.parametrize("label", ["time", "start"])
def test_a_time_outside_the_clip_is_refused_with_its_name(bank: Bank, label: str, time: float) -> None:
    at = {"time": 0.0, "start": 0.0, label: time}
    clip = "walk" if label == "time" else "wave"
    with pytest.raises(TimeRangeError, match=f"{label} .* outside clip '{clip}'.*Give a {label} from 0 to"):
        Evaluator(bank).pose(Splice("walk", "wave", start=at["start"]), at["time"])


def test_the_error_of_a_batch_names_the_invalid_request(bank: Bank) -> None:
    evaluator, requests = Evaluator(bank), Requests.empty(5)
    requests.time[3] = np.nan
    with pytest.raises(TimeRangeError, match="character 3"):
        evaluator.evaluate(requests, evaluator.poses(5))


@pytest.mark.parametrize(
    ("wrong", "kind", "words"),
    [
        ({"locomotion": "wlak"}, UnknownClipError, "Did you mean 'walk'"),
        ({"action": "carrybox"}, UnknownClipError, "Did you mean 'carry_box'"),
        ({"method": "splise"}, SettingsError, "Did you mean 'splice'"),
        ({"posture": "upright"}, SettingsError, "unknown posture"),
    ],
)
def test_the_error_of_an_unknown_name_suggests_similar_names(
    bank: Bank, wrong: dict[str, str], kind: type[MotionError], words: str
) -> None:
    splice = Splice(**{"locomotion": "walk", "action": "wave"} | wrong)  # type: ignore[arg-type]
    with pytest.raises(kind, match=words):
        Evaluator(bank).pose(splice, 0.0)


def test_numbers_out_of_range_and_wrong_sizes_are_refused(bank: Bank) -> None:
    evaluator = Evaluator(bank)
    with pytest.raises(SettingsError, match="room for 3 poses"):
        evaluator.evaluate(Requests.empty(2), evaluator.poses(3))
    for name in ("locomotion", "action", "method", "posture"):
        requests = Requests.empty(2)
        getattr(requests, name)[1] = 77
        with pytest.raises(SettingsError, match=f"{name} number"):
            evaluator.evaluate(requests, evaluator.poses(2))


def test_action_frames_are_the_frames_that_a_splice_plays(bank: Bank) -> None:
    evaluator = Evaluator(bank)
    frames = evaluator.action_frames(Splice("walk", "carry_box"), evaluator.frame_times("walk"))
    box, splice = bank.motion("carry_box"), evaluator.clip(Splice("walk", "carry_box"))
    own = frames <= box.frame_count - 1
    upper = [joint for joint in bank.skeleton.subtree(bank.roles.pelvis) if joint != bank.roles.pelvis]
    played = box.sampled(frames[own])[1]
    assert quaternion.angle(splice.rotations[own][:, upper], played[:, upper]).max() < 1e-4
    assert np.diff(frames[:120]).min() > 0.0
    assert own.sum() > 200


def test_a_running_posture_starts_from_the_stored_one_and_follows_the_splice(bank: Bank) -> None:
    evaluator = Evaluator(bank)
    absolute, running = (evaluator.clip(Splice("walk", "carry_box", posture=form)) for form in ("absolute", "running"))
    apart = quaternion.angle(absolute.rotations[:, bank.roles.pelvis], running.rotations[:, bank.roles.pelvis])
    assert apart[0] < np.radians(0.2)
    assert 0.0 < apart.max() < np.radians(4.0)


def test_characters_do_not_share_running_postures(bank: Bank) -> None:
    evaluator, box = Evaluator(bank), bank.number("carry_box")
    requests, running, poses = Requests.empty(3), Memory.begin(3, rate=30.0), evaluator.poses(3)
    requests.posture[:] = POSTURES["running"]
    requests.locomotion[:] = [bank.number(name) for name in ("walk", "run", "walk")]
    requests.action[:] = box
    for time in np.arange(0.0, 2.0, 1.0 / 30.0):
        requests.time[:] = time
        evaluator.evaluate(requests, poses, running)
    np.testing.assert_array_equal(running.means[0], running.means[2])
    assert np.abs(running.means[0] - running.means[1]).max() > 1e-3
    np.testing.assert_array_equal(poses.rotations[0], poses.rotations[2])


def test_a_running_posture_without_a_memory_is_refused(bank: Bank) -> None:
    with pytest.raises(SettingsError, match="needs a memory of them"):
        Evaluator(bank).pose(Splice("walk", "wave", posture="running"), 1.0)
    evaluator = Evaluator(bank)
    with pytest.raises(SettingsError, match="a memory of 3 characters or of 1"):
        evaluator.evaluate(Requests.empty(3), evaluator.poses(3), Memory.begin(2, rate=30.0))


def test_arrays_of_wrong_type_shape_or_layout_are_refused(bank: Bank) -> None:
    evaluator, joints = Evaluator(bank), bank.skeleton.joint_count
    for make in (
        lambda: Poses(np.empty((2, 3), np.float32), np.empty((2, joints, 4))),  # type: ignore[arg-type]
        lambda: Poses(np.empty((2, 3), np.float32), np.empty((2, 4, joints), np.float32).swapaxes(1, 2)),
        lambda: Poses(np.empty((3, 3), np.float32), np.empty((2, joints, 4), np.float32)),
        lambda: Poses(np.empty((3, 3), np.float32), np.empty(3, np.float32)),
        lambda: Requests(Requests.empty(4).records[::2]),
        lambda: Requests(np.zeros(2, [("locomotion", np.int64)])),
        lambda: Memory(np.zeros((2, 9)), 0.1),
        lambda: Memory(np.frombuffer(bytes(160)).reshape(2, 10), 0.1),
        lambda: Memory(np.frombuffer(bytearray(161), offset=1).reshape(2, 10), 0.1),
        lambda: evaluator.world_positions(evaluator.poses(2), np.empty((2, joints, 4), np.float32)),
    ):
        with pytest.raises(SettingsError, match="expected a contiguous array"):
            make()


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_arrays_of_a_copy_are_views_of_each_other_too(bank: Bank, again: Callable[[Any], Any]) -> None:
    evaluator, requests, memory = Evaluator(bank), again(Requests.empty(2)), again(Memory.begin(2, 60.0))
    poses = again(evaluator.poses(2).rows(0, 2))
    requests.time[:] = 0.5
    assert requests.records["time"].tolist() == [0.5, 0.5]
    evaluator.evaluate(requests, poses, memory)
    np.testing.assert_array_equal(poses.rotations[0].ravel(), poses.flat[0])
    name = bank.numbered[0].name
    np.testing.assert_array_equal(poses.rotations[0], evaluator.pose(Splice(name, name), 0.5).rotations[0])
    memory.turns[:] = 7.0
    assert (memory.state == 7.0).sum() == memory.turns.size


@pytest.mark.parametrize("times", [1.0, [[0.5, 1.0]], np.zeros((1, 1)), iter([1.0])])
def test_times_of_a_wrong_shape_are_refused(bank: Bank, times: Any) -> None:
    evaluator = Evaluator(bank)
    for ask in (evaluator.sequence, evaluator.action_frames):
        with pytest.raises(SettingsError, match=r"times: expected a list or an array \[n\] of seconds, found one"):
            ask(Splice("walk", "wave"), times)


def test_requests_may_be_read_only(bank: Bank) -> None:
    evaluator, requests = Evaluator(bank), Requests.empty(2)
    requests.time[:] = 0.5
    expected, found = evaluator.poses(2), evaluator.poses(2)
    evaluator.evaluate(requests, expected)
    evaluator.evaluate(Requests(np.frombuffer(requests.records.tobytes(), REQUEST)), found)
    assert found.rotations.tobytes() == expected.rotations.tobytes()


def test_an_empty_batch_is_valid(bank: Bank) -> None:
    evaluator = Evaluator(bank)
    evaluator.evaluate(Requests.empty(0), evaluator.poses(0))


@pytest.mark.parametrize(("rate", "time_constant"), [(0.0, 2.0), (-5.0, 2.0), (60.0, 0.0), (np.nan, 2.0)])
def test_a_memory_needs_a_rate_above_zero(rate: float, time_constant: float) -> None:
    with pytest.raises(SettingsError, match="above 0"):
        Memory.begin(1, rate, time_constant)


def test_arrays_cannot_be_replaced_since_others_are_views_of_them(bank: Bank) -> None:
    for arrays, name in ((Requests.empty(2), "time"), (Evaluator(bank).poses(2), "rotations")):
        before = vars(arrays)[name]
        with pytest.raises(SettingsError, match=rf"^'{name}' cannot be set. Write into arrays in place"):
            setattr(arrays, name, before.copy())
        assert getattr(arrays, name) is before
    requests = Requests.empty(2)
    requests.time += 0.5
    np.testing.assert_array_equal(requests.records["time"], 0.5)
