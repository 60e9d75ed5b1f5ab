"""State that all parts of one service process share."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property

from motionsplice.service.allowance import SharedAllowances
from motionsplice.service.arrivals import Arrivals
from motionsplice.service.metrics import Metrics
from motionsplice.service.problems import BusyError
from motionsplice.service.refusal_log import RefusalLog
from motionsplice.service.serving import Serving
from motionsplice.service.settings import Settings
from motionsplice.service.turns import Turns


@dataclass(frozen=True, eq=False)
class Shared:
    """The settings, the bank that is served, the metrics, the open streams, and whether the service is stopping.

    turns: for work whose length clients choose.
    batches: the characters that an address may ask for in batches: as many per second as all WebSockets, and as many at
        once as in a second.
    retargeting: held while a take is put onto a rig in a thread: one at a time, as that takes a core and much memory.
    estimating: held while a thread uses the edition's estimator.
    """

    settings: Settings
    serving: Serving
    metrics: Metrics
    stopping: asyncio.Event = field(default_factory=asyncio.Event)
    streams: set[object] = field(default_factory=set)
    retargeting: asyncio.Lock = field(default_factory=asyncio.Lock)
    estimating: asyncio.Lock = field(default_factory=asyncio.Lock)
    turns: Turns = field(default_factory=Turns)
    refusals: RefusalLog = field(default_factory=RefusalLog)

    @cached_property
    def arrivals(self) -> Arrivals:
        return Arrivals(self.stopping)

    @cached_property
    def batches(self) -> SharedAllowances:
        return SharedAllowances(self.settings.max_load, self.settings.max_load)

    @contextmanager
    def admitted(self) -> Iterator[None]:
        """Admits a stream while the context lasts. Raises BusyError if `max_streams` are open."""
        if len(self.streams) >= self.settings.max_streams:
            problem = f"this process already serves {self.settings.max_streams} streams, which is its limit"
            raise BusyError(problem, mend="Try again later, or ask another process")
        stream = object()
        self.streams.add(stream)
        try:
            yield
        finally:
            self.streams.discard(stream)
