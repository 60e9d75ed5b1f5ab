from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
from fastapi.testclient import TestClient

from runtime.bank import Bank
from service.app import create_app
from service.settings import Settings


@pytest.fixture(scope="session")
def client(bank: Bank) -> Iterator[TestClient]:
    """A client of a running, warm service."""
    with TestClient(create_app(bank, Settings(max_frames=5000))) as client:
        wait_until_ready(client)
        yield client


def wait_until_ready(client: TestClient) -> None:
    """Returns when the kernels are warm, and fails if that takes more than a minute."""
    deadline = time.monotonic() + 60.0
    while client.get("/readyz").status_code == 503:
        assert time.monotonic() < deadline
        time.sleep(0.01)
