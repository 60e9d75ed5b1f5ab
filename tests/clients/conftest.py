from __future__ import annotations

from pathlib import Path

import pytest

from tests.clients import cpp


@pytest.fixture(scope="session")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program that evaluates requests by the evaluator in C++."""
    return cpp.compiled("evaluate.cpp", tmp_path_factory.mktemp("cpp") / "evaluate", "-O2", *cpp.BARE)
