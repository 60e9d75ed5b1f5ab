from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.service.running import Running, eventually


@pytest.fixture(autouse=True)
def no_connection_is_left(impatient: Running) -> Iterator[None]:
    """Checks after each test that the module's service holds no connections, tasks or streams."""
    yield
    eventually(lambda: impatient.held == (0, 0, 0, 0))
