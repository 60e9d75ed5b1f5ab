from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from fastapi.testclient import TestClient

from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.settings import Settings
from tests.service.running import COMPILING, Running, running


@contextmanager
def warm_client(bank: Bank) -> Iterator[TestClient]:
    with TestClient(create_app(bank, Settings(max_frames=5000))) as client:
        deadline = time.monotonic() + COMPILING
        while client.get("/readyz").status_code == 503:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        yield client


@pytest.fixture(scope="session")
def client(bank: Bank) -> Iterator[TestClient]:
    """A client of a ready service, without sockets."""
    with warm_client(bank) as client:
        yield client


@pytest.fixture(scope="session")
def hands_client(hands_bank: Bank) -> Iterator[TestClient]:
    """A client of a service with hands."""
    with warm_client(hands_bank) as client:
        yield client


@pytest.fixture(scope="module")
def service(bank: Bank) -> Iterator[Running]:
    """A running, ready service."""
    with running(bank.path, Settings(stall_seconds=2.0, idle_seconds=1.0, max_load=20_000)) as service:
        yield service


@pytest.fixture(scope="module")
def hands_service(hands_bank: Bank) -> Iterator[Running]:
    """A running, ready service with hands, and a receiver that does not run."""
    with running(hands_bank.path, Settings(vmc="127.0.0.1:9")) as service:
        yield service
