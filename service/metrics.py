"""Metrics for Prometheus (docs/operation.md). With several workers, each reports the sum of all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.metrics_core import Metric
from prometheus_client.multiprocess import MultiProcessCollector, mark_process_dead

SHARED_FOLDER = "PROMETHEUS_MULTIPROC_DIR"  # where workers write metrics; prometheus_client reads it at import
# prometheus_client names version 1.0.0, which only new collectors know, and which they must ask for
MEDIA_TYPE = "text/plain; version=0.0.4; charset=utf-8"
BANK = "motionsplice_bank_info"
SECONDS = (*(base * 10.0**power for power in range(-4, 0) for base in (1.0, 2.0, 5.0)), 1.0)


class Metrics:
    """The metrics of one process."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self.frames_sent = Counter("motionsplice_frames_sent", "Frames sent on streams", registry=self._registry)
        self.frames_skipped = Counter(
            "motionsplice_frames_skipped",
            "Frames skipped because a client or the clock was too slow",
            registry=self._registry,
        )
        self.tick_lateness = Histogram(
            "motionsplice_tick_lateness_seconds",
            "Delay between when frames were due and when their evaluation began",
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
            "motionsplice_bank_exchanges", "New banks that were served or refused", ["result"], registry=self._registry
        )
        self._datagrams = Counter(
            "motionsplice_datagrams",
            "Datagrams to receivers of VMC and JSON Live Link: sent, or refused by the system",
            ["receiver", "result"],
            registry=self._registry,
        )
        self._connections = Gauge(
            "motionsplice_connections",
            "Open connections: http counts all, stream and characters the streaming ones",
            ["kind"],
            registry=self._registry,
            multiprocess_mode="livesum",
        )
        self._bank = Gauge(
            BANK, "The bank that is served", ["digest"], registry=self._registry,
            multiprocess_mode="livemax",
        )  # fmt: skip
        self._requests = Counter(
            "motionsplice_requests", "Requests answered", ["route", "status"], registry=self._registry
        )
        self._answered: dict[tuple[str, int], Counter] = {}
        self._digest = ""

    def connections(self, kind: str) -> Gauge:
        """Returns the gauge of a kind: `http` for all connections, `stream` and `characters` for streaming ones."""
        return self._connections.labels(kind)

    @contextmanager
    def connection(self, kind: str) -> Iterator[None]:
        """Counts a connection while the context lasts."""
        with self.connections(kind).track_inprogress():
            yield

    def datagrams(self, receiver: str, sent: int, refused: int) -> None:
        """Counts datagrams to a kind of receiver."""
        self._datagrams.labels(receiver, "sent").inc(sent)
        self._datagrams.labels(receiver, "refused").inc(refused)

    def answered(self, route: str, status: int) -> None:
        """Counts a request. `route` is one of a few constants, never text from a client."""
        counter = self._answered.get((route, status))
        if counter is None:
            counter = self._answered[route, status] = self._requests.labels(route, str(status))
        counter.inc()

    def serves(self, digest: str) -> None:
        """Records the digest of the bank that is served."""
        if self._digest and self._digest != digest:
            self._bank.labels(self._digest).set(0)
            if SHARED_FOLDER not in os.environ:  # what workers have written stays; `Together` leaves it out
                self._bank.remove(self._digest)
        self._bank.labels(digest).set(1)
        self._digest = digest

    def render(self) -> tuple[bytes, str]:
        """Returns all metrics in Prometheus' text format, and its media type."""
        registry = self._registry
        if SHARED_FOLDER in os.environ:
            forget_the_dead(Path(os.environ[SHARED_FOLDER]))
            registry = CollectorRegistry()
            Together(registry)  # type: ignore[no-untyped-call]
        return generate_latest(registry), MEDIA_TYPE


class Together(MultiProcessCollector):
    """Collects what all workers have written, but for banks that none of them serves any more."""

    def collect(self) -> Iterator[Metric]:
        for metric in super().collect():  # type: ignore[no-untyped-call]
            if metric.name == BANK:
                metric.samples = [sample for sample in metric.samples if sample.value]
            yield metric


def forget_the_dead(folder: Path) -> None:
    """Removes what workers that were killed have written of themselves, such as their open connections."""
    for process in {file.stem.rpartition("_")[2] for file in folder.glob("gauge_live*.db")}:
        try:
            os.kill(int(process), 0)
        except ProcessLookupError:
            with suppress(FileNotFoundError):  # another worker forgets it too
                mark_process_dead(int(process), str(folder))  # type: ignore[no-untyped-call]
        except PermissionError:  # alive, or its number is another user's now
            continue
