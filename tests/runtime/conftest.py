from __future__ import annotations

import pytest

from runtime.bank import Bank
from runtime.character import Characters
from runtime.evaluator import Evaluator
from runtime.stage import Stage
from tests.playing import RATE, Setup


@pytest.fixture(scope="session")
def stage(bank: Bank) -> Stage:
    return Stage(Evaluator(bank))


@pytest.fixture
def one(stage: Stage) -> Setup:
    return lambda: Characters(stage, RATE)
