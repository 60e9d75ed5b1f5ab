"""Logs refused requests. A flood of them must not flood the log."""

from __future__ import annotations

import logging
import time
from collections import Counter
from collections.abc import Callable

logger = logging.getLogger(__name__)

PERIOD = 10.0  # seconds after which lines are counted anew
MOST, MOST_OF_ALL = 100, 1000  # lines in a period: of one address, and of all together


class RefusalLog:
    """Logs the refusals of a process, up to so many in a period. The next line says how many were left out."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._since = clock()
        self._lines: Counter[str] = Counter()
        self._all = self._unlogged = 0

    def note(self, identity: str, address: str, status: int, detail: str, path: str = "") -> None:
        """Logs a refusal by the request's id, unless this address, or all together, have had their lines."""
        now = self._clock()
        if now - self._since >= PERIOD:
            self._since, self._all = now, 0
            self._lines.clear()
        if self._lines[address] >= MOST or self._all >= MOST_OF_ALL:
            self._unlogged += 1
            return
        self._lines[address] += 1
        self._all += 1
        fields: dict[str, object] = {"request_id": identity, "address": address, "status": status, "detail": detail}
        if path:
            fields["path"] = path
        if self._unlogged:
            fields["unlogged"], self._unlogged = self._unlogged, 0
        logger.info("refused", extra=fields)
