"""What is counted, for Prometheus (docs/operation.md). With several workers any of them tells the sum of all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from prometheus_client import CONTENT_TYPE_LATEST, CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.multiprocess import MultiProcessCollector

SHARED_FOLDER = "PROMETHEUS_MULTIPROC_DIR"  # where workers put their numbers; prometheus_client reads it when imported
SECONDS = (*(base * 10.0**power for power in range(-4, 0) for base in (1.0, 2.0, 5.0)), 1.0)


class Metrics:
    """The numbers of one process."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self.frames_sent = Counter("motionsplice_frames_sent", "Frames sent on streams", registry=self._registry)
        self.frames_skipped = Counter(
            "motionsplice_frames_skipped",
            "Frames that a client was too slow for, or the clock",
            registry=self._registry,
        )
        self.tick_lateness = Histogram(
            "motionsplice_tick_lateness_seconds",
            "How late frames were begun to be made",
            registry=self._registry,
            buckets=SECONDS,
        )
        self.evaluation = Histogram(
            "motionsplice_evaluation_seconds",
            "Time to evaluate and encode a batch of characters",
            registry=self._registry,
            buckets=SECONDS,
        )
        self.exchanges = Counter(
            "motionsplice_bank_exchanges", "Banks that were taken or refused", ["result"], registry=self._registry
        )
        self._connections = Gauge(
            "motionsplice_connections",
            "Open connections, and what runs on them",
            ["kind"],
            registry=self._registry,
            multiprocess_mode="livesum",
        )
        self._bank = Gauge(
            "motionsplice_bank_info", "The bank that is served", ["digest"], registry=self._registry,
            multiprocess_mode="livemax",
        )  # fmt: skip
        self._requests = Counter(
            "motionsplice_requests", "Requests answered", ["route", "status"], registry=self._registry
        )
        self._answered: dict[tuple[str, int], Counter] = {}
        self._digest = ""

    def connections(self, kind: str) -> Gauge:
        """How many there are: `http` of them all, `stream` and `characters` of those that stream."""
        return self._connections.labels(kind)

    @contextmanager
    def connection(self, kind: str) -> Iterator[None]:
        """Counts one for as long as it lasts."""
        with self.connections(kind).track_inprogress():
            yield

    def answered(self, route: str, status: int) -> None:
        """Counts a request; `route` is one of few, never a client's own text."""
        counter = self._answered.get((route, status))
        if counter is None:
            counter = self._answered[route, status] = self._requests.labels(route, str(status))
        counter.inc()

    def serves(self, digest: str) -> None:
        """Tells which bank is served now."""
        if self._digest and self._digest != digest:
            self._bank.labels(self._digest).set(0)
            self._bank.remove(self._digest)
        self._bank.labels(digest).set(1)
        self._digest = digest

    def render(self) -> tuple[bytes, str]:
        """All numbers in Prometheus' text format, and its media type."""
        registry = self._registry
        if SHARED_FOLDER in os.environ:
            registry = CollectorRegistry()
            MultiProcessCollector(registry)  # type: ignore[no-untyped-call]
        return generate_latest(registry), CONTENT_TYPE_LATEST
