"""The evaluator in C++, against the compiled kernels: two implementations of docs/bank.md."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.errors import MotionError, SettingsError, TimeRangeError, UnknownClipError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import METHODS, POSTURES, Memory, Requests
from motionsplice.runtime.stage import Stage
from tests import random_bank
from tests.clients import cpp

pytestmark = cpp.needs_compiler
RATE = 60.0
seeds = st.integers(0, 2**32 - 1)


def drawn(bank: Bank, count: int, seed: int) -> Requests:
    """Random requests: all clips and mirror images, methods, postures, hands, any time of a clip, some at its ends."""
    draw, requests = np.random.default_rng(seed), Requests.empty(count)
    requests.locomotion[:], requests.action[:] = draw.integers(0, len(bank.numbered), (2, count))
    requests.method[:] = draw.choice(list(METHODS.values()), count, p=[0.1, 0.2, 0.7])
    requests.posture[:] = draw.choice(list(POSTURES.values()), count)
    requests.cycles[:] = draw.integers(-3, 9, count) * draw.integers(0, 2, count)
    durations = np.array([clip.duration for clip in bank.numbered])
    shares = np.clip(draw.uniform(-0.2, 1.2, (2, count)), 0.0, 1.0)
    requests.time[:] = shares[0] * durations[requests.locomotion]
    requests.start[:] = shares[1] * durations[requests.action] * draw.integers(0, 2, count)
    for request in requests.records:
        upper = request["locomotion" if request["method"] == METHODS["none"] else "action"] % len(bank.clips)
        aligned = [bank.hand_number(one.name) for one in bank.hands if one.body == bank.clips[upper].name]
        request["hands"] = 1 + draw.choice(aligned) if aligned and draw.random() < 0.7 else 0
    return requests


def agree(bank: Bank, program: Path, folder: Path, batches: list[Requests], remembers: bool = True) -> None:
    """Evaluates batches about the same characters, one after the other, and compares both implementations."""
    joints, count = bank.skeleton.joint_count, len(batches[0])
    evaluator, memory = Evaluator(bank), Memory.begin(count, RATE) if remembers else None
    if not remembers:
        for batch in batches:
            batch.posture[batch.posture == POSTURES["running"]] = POSTURES["relative"]
    lines = cpp.run(program, folder, "".join(cpp.command(batch, RATE if remembers else 0.0) for batch in batches))
    for number, batch in enumerate(batches):
        ours, positions = evaluator.poses(count), np.empty((count, joints, 3), np.float32)
        evaluator.evaluate(batch, ours, memory)
        evaluator.world_positions(ours, positions)
        theirs = cpp.answer(lines[number * count : (number + 1) * count], joints)
        assert theirs.allocations == 0
        np.testing.assert_allclose(theirs.roots, ours.root_positions, atol=1e-5)
        assert quaternion.angle(theirs.rotations, ours.rotations).max() < 1e-5
        size = np.abs(positions).max()
        np.testing.assert_allclose(theirs.positions, positions, atol=1e-5 * max(size, 1.0))


@given(seeds)
@settings(max_examples=20)
def test_the_test_bank_is_evaluated_as_by_the_kernels(bank: Bank, program: Path, seed: int) -> None:
    agree(bank, program, bank.path, [drawn(bank, 40, seed), drawn(bank, 40, seed + 1)])


@given(seeds)
@settings(max_examples=20)
def test_hands_are_laid_as_by_the_kernels(hands_bank: Bank, program: Path, seed: int) -> None:
    agree(hands_bank, program, hands_bank.path, [drawn(hands_bank, 40, seed)])


@given(seeds)
@settings(max_examples=20)
def test_actions_captured_standing_are_added_as_by_the_kernels(standing_bank: Bank, program: Path, seed: int) -> None:
    agree(
        standing_bank, program, standing_bank.path, [drawn(standing_bank, 40, seed), drawn(standing_bank, 40, seed + 1)]
    )


@given(seeds, st.integers(3, 60), st.integers(3, 20), st.sampled_from(random_bank.CLOUDS), st.booleans(), st.booleans())
@settings(max_examples=60)
def test_random_banks_are_evaluated_as_by_the_kernels(
    program: Path, seed: int, joints: int, points: int, clouds: str, remembers: bool, hybrids: bool
) -> None:
    bank = random_bank.random_bank(seed, joints, 3, points, clouds, hybrids)
    clips = tuple(replace(clip, gait=number != 1) for number, clip in enumerate(bank.clips))
    bank = replace(bank, manifest=replace(bank.manifest, clips=clips))
    with tempfile.TemporaryDirectory() as folder:
        batches = [drawn(bank, 20, seed), drawn(bank, 20, seed + 1)]
        agree(bank, program, cpp.written(bank, Path(folder) / "bank"), batches, remembers)


def test_one_character_is_evaluated_as_in_a_batch(bank: Bank, program: Path) -> None:
    batch = drawn(bank, 40, 5)
    together = cpp.run(program, bank.path, cpp.command(batch, RATE))
    for k in (7, 23):
        assert cpp.run(program, bank.path, cpp.command(Requests(batch.records[k : k + 1]), RATE)) == together[k : k + 1]


@pytest.mark.parametrize("seconds", [1.0 / 60.0, 1.0 / 144.0, 9.0])
def test_a_walking_character_has_the_root_motion_and_the_place_of_characters(
    bank: Bank, program: Path, seconds: float
) -> None:
    loops = [clip for clip in bank.numbered if clip.loop]
    assert loops
    for clip in loops:
        steps = 1000 if seconds < 1.0 else 5
        walked = cpp.run(program, bank.path, f"walk {bank.number(clip.name)} 0 {seconds} {steps}")
        characters = Characters(Stage(Evaluator(bank)), 1.0 / seconds)
        characters.add(1, clip.name)
        poses, rounds = characters.stage.evaluator.poses(1), 0
        for line in walked:
            numbers = np.array(line.split(), np.float64)
            characters.advance()
            characters.evaluate(poses)
            np.testing.assert_allclose(numbers[:4], characters.deltas[0], atol=1e-6)
            np.testing.assert_allclose(numbers[6:9], poses.root_positions[0], atol=1e-5)
            assert quaternion.angle(numbers[9:], poses.rotations[0, 0]) < 1e-5
            rounds += int(numbers[5]) // clip.loop
        assert rounds > 0, clip.name


def test_a_clip_without_a_loop_stops_at_its_end(program: Path, tmp_path: Path) -> None:
    bank = next(
        bank
        for bank in (random_bank.random_bank(seed, 8, 2, 3, "torso") for seed in range(100))
        if bank.clips[0].loop == 0
    )
    duration = bank.clips[0].duration
    [line] = cpp.run(program, cpp.written(bank, tmp_path / "bank"), f"walk 0 {duration / 2} 100 1")
    assert float(line.split()[4]) == pytest.approx(duration)
    assert line.split()[5] == "0"


def test_names_are_found_as_by_the_bank(bank: Bank, program: Path) -> None:
    known, unknown = [clip.name for clip in bank.numbered], ["~mirror", "walk~mirror~mirror", "absent~mirror", "walk~"]
    lines = cpp.run(program, bank.path, "".join(f"find {name}\n" for name in [*known, *unknown]))
    assert lines[len(known) :] == ["-1"] * len(unknown)
    for clip, line in zip(bank.numbered, lines[: len(known)], strict=True):
        number, first, last, name = line.split(maxsplit=3)
        assert (int(number), name) == (bank.number(clip.name), clip.name)
        np.testing.assert_allclose([float(first), float(last)], [clip.first_phase, clip.last_phase], rtol=1e-8)
    for name in unknown:
        with pytest.raises(UnknownClipError):
            bank.number(name)


def test_a_rig_without_a_mirror_image_says_so(program: Path, tmp_path: Path) -> None:
    bank = random_bank.random_bank(2, 12, 2, 4, "torso")
    lame = replace(bank, manifest=replace(bank.manifest, mirror=None))
    folder = cpp.written(lame, tmp_path / "bank")
    agree(lame, program, folder, [drawn(lame, 20, 1)])
    with pytest.raises(UnknownClipError) as error:
        lame.number("clip 1~mirror")
    commands = ["poses 1 0\n3 0 -2 0 2 1 0 0", "poses 1 0\n0 3 -2 0 2 1 0 0", "walk 3 0 0.1 1"]
    for line in cpp.run(program, folder, "\n".join(commands)):
        assert line == f"error settings {error.value}."


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"time": -0.1}, TimeRangeError),
        ({"time": math.nan}, TimeRangeError),
        ({"time": 1000.0}, TimeRangeError),
        ({"start": -0.5}, TimeRangeError),
        ({"start": math.nan}, TimeRangeError),
        ({"start": 99.0}, TimeRangeError),
        ({"locomotion": 99}, SettingsError),
        ({"action": -1}, SettingsError),
        ({"method": 3}, SettingsError),
        ({"posture": 5}, SettingsError),
        ({"posture": POSTURES["running"]}, SettingsError),
        ({"hands": 1, "action": 1}, SettingsError),
        ({"hands": 9}, SettingsError),
    ],
)
def test_invalid_requests_give_errors_of_the_same_kind(
    hands_bank: Bank, program: Path, change: dict[str, Any], error: type[MotionError]
) -> None:
    requests = Requests.empty(3)
    for name, value in change.items():
        requests.records[name][1] = value
    if change.get("hands") == 1:
        requests.action[1] = hands_bank.number("wave")
    with pytest.raises(error, match="character 1"):
        Evaluator(hands_bank).evaluate(requests, Evaluator(hands_bank).poses(3))
    [line] = cpp.run(program, hands_bank.path, cpp.command(requests))
    kind = {TimeRangeError: "time_range", SettingsError: "settings"}[error]
    assert line.startswith(f"error {kind} character 1: ")


def test_names_that_are_not_found_are_refused_and_not_taken_for_nothing(bank: Bank, program: Path) -> None:
    for columns in ("0 -1 -2", "0 0 -1"):
        [line] = cpp.run(program, bank.path, f"poses 1 0\n{columns} 0 2 1 0 0")
        assert line.startswith("error settings")
    [line] = cpp.run(program, bank.path, "walk -1 0 0.1 1")
    assert line.startswith("error settings")


def test_the_program_of_the_readme_walks(bank: Bank, tmp_path: Path) -> None:
    page = (cpp.CLIENT / "README.md").read_text(encoding="utf-8")
    program = re.search(r"^```cpp\n(.*?)^```", page, re.S | re.M)
    options = re.search(r"^g\+\+ (.*) walk.cpp -o walk", page, re.M)
    assert program is not None
    assert options is not None
    (tmp_path / "walk.cpp").write_text(program[1])
    (tmp_path / "demo").mkdir()
    shutil.copytree(bank.path, tmp_path / "demo" / "bank")
    build = ["g++", *options[1].split(), "-I", cpp.CLIENT, "walk.cpp", "-o", "walk"]
    subprocess.run(build, cwd=tmp_path, check=True, capture_output=True)
    lines = subprocess.run([tmp_path / "walk"], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    ahead = [float(line.split()[-1]) for line in lines.splitlines()]
    assert len(ahead) == 10
    assert np.diff(ahead).min() > 0.8  # metres per second, through two loops
    assert f"That is 3 commands and {len(program[1].splitlines())} lines" in page
