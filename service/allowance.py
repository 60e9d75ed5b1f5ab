"""How much work clients may cause: so much per second, and a burst that all connections of an address share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

BURST = 10_000.0  # commands that an address may send at once before its connections wait
AT_HAND = 0.1  # seconds of a connection's rate that it may save up for itself


class Allowance:
    """An amount that grows by `rate` per second up to `most`, and from which work is charged.

    Args:
        rate: Growth per second.
        most: The most that can be saved up.
        now: A moment in seconds, as in all methods.
        left: The amount at this moment.
        shared: An allowance that is drawn upon when this one is used up.
    """

    def __init__(
        self, rate: float, most: float, now: float, *, left: float = 0.0, shared: Allowance | None = None
    ) -> None:
        self._rate, self._most, self._left, self._since, self._shared = rate, most, left, now, shared

    def charge(self, cost: float, now: float) -> float:
        """Charges work, before it is done. Returns the seconds to wait before doing it."""
        self._left = self.left(now) - cost
        self._since = now
        if self._left < 0.0 and self._shared is not None:
            self._left += self._shared.draw(-self._left, now)
        return max(0.0, -self._left / self._rate)

    def draw(self, wanted: float, now: float) -> float:
        """Takes what there is of an amount, and returns it."""
        drawn = min(wanted, self.left(now))
        self._left, self._since = self.left(now) - drawn, now
        return drawn

    def left(self, now: float) -> float:
        """Returns the amount at a moment."""
        return min(self._most, self._left + (now - self._since) * self._rate)


class Allowances:
    """The allowances of all connections. Those of an address share its burst, also with connections that ended."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._bursts: dict[str, Allowance] = {}
        self._open: dict[str, int] = {}

    @contextmanager
    def of(self, address: str, now: float) -> Iterator[Allowance]:
        """Opens the allowance of a connection, which begins with nothing of its own."""
        for other in [one for one, burst in self._bursts.items() if one not in self._open and burst.left(now) >= BURST]:
            del self._bursts[other]
        burst = self._bursts.setdefault(address, Allowance(self._rate, BURST, now, left=BURST))
        self._open[address] = self._open.get(address, 0) + 1
        try:
            yield Allowance(self._rate, AT_HAND * self._rate, now, shared=burst)
        finally:
            self._open[address] -= 1
            if not self._open[address]:
                del self._open[address]

    def __len__(self) -> int:
        """The number of addresses whose bursts are remembered."""
        return len(self._bursts)
