"""The evaluator in C++, against the compiled kernels: two implementations of docs/bank.md."""

from __future__ import annotations

import itertools
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import METHODS, POSTURES, Memory, Requests
from tests import random_bank
from tests.clients import cpp

pytestmark = cpp.needs_compiler
RATE = 60.0
seeds = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="session")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return cpp.compiled("evaluate.cpp", tmp_path_factory.mktemp("cpp") / "evaluate", "-O2", *cpp.BARE)


def drawn(bank: Bank, count: int, seed: int) -> Requests:
    """Random requests: all methods, postures and hands, any time of a clip, some at its very ends."""
    draw, requests = np.random.default_rng(seed), Requests.empty(count)
    requests.locomotion[:], requests.action[:] = draw.integers(0, len(bank.clips), (2, count))
    requests.method[:] = draw.choice(list(METHODS.values()), count, p=[0.1, 0.2, 0.7])
    requests.posture[:] = draw.choice(list(POSTURES.values()), count)
    requests.cycles[:] = draw.integers(-3, 9, count) * draw.integers(0, 2, count)
    durations = np.array([clip.duration for clip in bank.clips])
    shares = np.clip(draw.uniform(-0.2, 1.2, (2, count)), 0.0, 1.0)
    requests.time[:] = shares[0] * durations[requests.locomotion]
    requests.start[:] = shares[1] * durations[requests.action] * draw.integers(0, 2, count)
    for request in requests.records:
        upper = bank.clips[request["locomotion" if request["method"] == METHODS["none"] else "action"]].name
        aligned = [bank.hand_number(one.name) for one in bank.hands if one.body == upper]
        request["hands"] = 1 + draw.choice(aligned) if aligned and draw.random() < 0.7 else 0
    return requests


def agree(bank: Bank, program: Path, folder: Path, batches: list[Requests], radians: float = 1e-5) -> None:
    """Evaluates batches about the same characters, one after the other, and compares both implementations."""
    evaluator, memory = Evaluator(bank), Memory.begin(len(batches[0]), RATE)
    joints, count = bank.skeleton.joint_count, len(batches[0])
    lines = cpp.run(program, folder, "".join(cpp.command(batch, RATE) for batch in batches))
    for batch, found in zip(batches, itertools.batched(lines, count) if False else _groups(lines, count), strict=True):
        ours, positions = evaluator.poses(count), np.empty((count, joints, 3), np.float32)
        evaluator.evaluate(batch, ours, memory)
        evaluator.world_positions(ours, positions)
        theirs = cpp.answer(found, joints)
        assert theirs.allocations == 0
        np.testing.assert_allclose(theirs.roots, ours.root_positions, atol=1e-5)
        angles = quaternion.angle(theirs.rotations, ours.rotations)
        print('A', angles.max(), np.abs(theirs.positions - positions).max())
        assert angles.max() < radians
        size = np.abs(positions).max()
        np.testing.assert_allclose(theirs.positions, positions, atol=1e-5 * max(size, 1.0))


def _groups(lines: list[str], count: int) -> list[list[str]]:
    return [lines[at : at + count] for at in range(0, len(lines), count)]


@given(seeds)
@settings(max_examples=20)
def test_the_test_bank_is_evaluated_as_by_the_kernels(bank: Bank, program: Path, seed: int) -> None:
    agree(bank, program, bank.path, [drawn(bank, 40, seed), drawn(bank, 40, seed + 1)])


@given(seeds)
@settings(max_examples=20)
def test_hands_are_laid_as_by_the_kernels(hands_bank: Bank, program: Path, seed: int) -> None:
    agree(hands_bank, program, hands_bank.path, [drawn(hands_bank, 40, seed)])


@given(seeds, st.integers(3, 60), st.integers(3, 20), st.sampled_from(random_bank.CLOUDS))
@settings(max_examples=40)
def test_random_banks_are_evaluated_as_by_the_kernels(
    program: Path, seed: int, joints: int, points: int, clouds: str
) -> None:
    bank = random_bank.random_bank(seed, joints, 3, points, clouds)
    with tempfile.TemporaryDirectory() as folder:
        agree(bank, program, cpp.written(bank, Path(folder) / "bank"), [drawn(bank, 20, seed), drawn(bank, 20, seed + 1)])
