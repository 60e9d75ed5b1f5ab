from __future__ import annotations

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
        while client.get("/readyz").status_code == 503:
            pass
        yield client
