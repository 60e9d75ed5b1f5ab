"""Counts open connections, in total and from each address."""

from __future__ import annotations

from asyncio import BaseTransport
from collections import Counter

from prometheus_client import Gauge


class Ledger:
    """The connections of one process. A transport counts once, even if it changes its protocol."""

    def __init__(self, most: int, most_per_address: int, gauge: Gauge) -> None:
        self._most = most
        self._most_per_address = most_per_address
        self._gauge = gauge
        self._addresses: dict[BaseTransport, str] = {}
        self._counts: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self._addresses)

    def admit(self, transport: BaseTransport) -> str:
        """Admits a connection. Returns the reason if a limit forbids it, else an empty text."""
        peer = transport.get_extra_info("peername")
        address = str(peer[0]) if peer else ""
        if len(self._addresses) >= self._most:
            return f"the service already has {self._most} connections, which is its limit"
        if self._counts[address] >= self._most_per_address:
            return f"this address already has {self._most_per_address} connections, which is its limit"
        self._addresses[transport] = address
        self._counts[address] += 1
        self._gauge.inc()
        return ""

    def forget(self, transport: BaseTransport) -> None:
        """Removes a connection, if it was admitted."""
        address = self._addresses.pop(transport, None)
        if address is None:
            return
        self._gauge.dec()
        self._counts[address] -= 1
        if not self._counts[address]:
            del self._counts[address]
