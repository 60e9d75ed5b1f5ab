"""Kernels find arrays by their addresses, so evaluators and stages keep these arrays, and tables stay mapped."""

from __future__ import annotations

import copy
import gc
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.aim import Look
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Requests
from motionsplice.runtime.stage import Stage


@pytest.fixture
def copied(bank: Bank, tmp_path: Path) -> Path:
    return Path(shutil.copytree(bank.path, tmp_path / "bank"))


def overwrite_freed_memory() -> None:
    gc.collect()
    for size in (64, 1024, 16_384, 262_144):
        assert sum(one[0] for one in [np.full(size, np.nan, np.float32) for _ in range(200)]) != 0.0


def test_an_evaluator_keeps_the_arrays_of_a_bank_that_is_gone(copied: Path) -> None:
    evaluator, requests = Evaluator(Bank.open(copied)), Requests.empty(40)
    requests.locomotion[:] = np.arange(40) % len(evaluator.bank.clips)
    requests.action[:] = np.arange(40) // 3 % len(evaluator.bank.clips)
    requests.time[:] = 0.01 * np.arange(40)
    expected, found = evaluator.poses(40), evaluator.poses(40)
    evaluator.evaluate(requests, expected)
    shutil.rmtree(copied)
    del evaluator.bank, evaluator.arrays, evaluator.scratch
    overwrite_freed_memory()
    evaluator.evaluate(requests, found)
    assert found.rotations.tobytes() == expected.rotations.tobytes()
    assert found.root_positions.tobytes() == expected.root_positions.tobytes()


@pytest.mark.parametrize("copied_by", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_copy_of_a_stage_has_arrays_of_its_own(bank: Bank, copied_by: Callable[[Stage], Stage]) -> None:
    stage = Stage(Evaluator(bank))
    expected, twin = played(stage), copied_by(stage)
    del stage
    overwrite_freed_memory()
    assert played(twin) == expected


def played(stage: Stage) -> bytes:
    characters = Characters(stage, 30.0)
    rows = characters.add(3, {"walk": 1.0, "run": 0.5})
    characters.act(rows[:2], Action("wave"))
    characters.look(rows[1:], Look([1.0, 1.5, 2.0]))
    characters.lock_feet(rows)
    poses, found = stage.evaluator.poses(3), b""
    for _ in range(20):
        characters.advance()
        characters.evaluate(poses)
        found += poses.rotations.tobytes() + characters.state.tobytes()
    return found


def test_a_stage_keeps_the_arrays_of_characters(copied: Path) -> None:
    stage = Stage(Evaluator(Bank.open(copied)))
    expected = played(stage)
    shutil.rmtree(copied)
    few = SimpleNamespace(limbs=stage.arrays.limbs, legs=stage.arrays.legs)
    stage.arrays = few  # type: ignore[assignment]
    del stage.evaluator.arrays, stage.evaluator.scratch
    overwrite_freed_memory()
    assert played(stage) == expected
