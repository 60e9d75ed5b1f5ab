from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.service.running import Running, eventually


@pytest.fixture(autouse=True)
def nothing_is_left(impatient: Running) -> Iterator[None]:
    """After each test the service, which each module makes as it needs it, holds nothing more of its clients."""
    yield
    eventually(lambda: impatient.held == (0, 0, 0, 0))
