from __future__ import annotations

import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from tests.playing import RATE, Setup


@pytest.fixture(scope="session")
def stage(bank: Bank) -> Stage:
    return Stage(Evaluator(bank))


@pytest.fixture
def one(stage: Stage) -> Setup:
    return lambda: Characters(stage, RATE)
