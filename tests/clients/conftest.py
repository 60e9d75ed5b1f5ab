from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.clients import cpp
from tests.clients.happenings import newer_bank
from tests.service.running import Running, running


@pytest.fixture(scope="session")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program that evaluates requests by the evaluator in C++."""
    return cpp.compiled("evaluate.cpp", tmp_path_factory.mktemp("cpp") / "evaluate", "-O2", *cpp.BARE)


@pytest.fixture(scope="module")
def other(clip_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """A newer bank: the run is another one."""
    return newer_bank(clip_folder, tmp_path_factory.mktemp("other"))


@pytest.fixture(scope="module")
def service(bank: Bank) -> Iterator[Running]:
    """A running, ready service."""
    with running(bank.path, Settings()) as service:
        yield service
