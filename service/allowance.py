"""How much work clients may cause: so much per second, and a burst that all connections of an address share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

BURST = 10_000.0  # commands that an address may send at once before its connections wait
AT_HAND = 0.1  # seconds of a connection's rate that it saves up for itself before the burst gets what it does not use


class Burst:
    """The budget of an address for bursts beyond the rates of its connections.

    It grows by what they do not use, and while there are none by the rate of one.
    """

    def __init__(self, rate: float, now: float) -> None:
        self.connections = 0
        self._rate, self._left, self._since = rate, BURST, now

    def left(self, now: float) -> float:
        """Returns the amount at a moment."""
        grown = 0.0 if self.connections else (now - self._since) * self._rate
        return min(BURST, self._left + grown)

    def count(self, change: int, now: float) -> None:
        """Changes the number of connections."""
        self._left, self._since = self.left(now), now
        self.connections += change

    def add(self, amount: float) -> None:
        """Adds what a connection did not use."""
        self._left = min(BURST, self._left + amount)

    def draw(self, wanted: float) -> float:
        """Takes what there is of an amount, for a connection. Returns how much it is."""
        drawn = min(wanted, self._left)
        self._left -= drawn
        return drawn


class Allowance:
    """An amount that grows by `rate` per second up to `most`, and from which work is charged.

    Args:
        rate: Growth per second.
        most: The most that can be saved up.
        now: A moment in seconds, as in all methods.
        left: The amount at this moment.
        burst: What is drawn upon when the allowance is used up. It gets what exceeds `most`.
    """

    def __init__(self, rate: float, most: float, now: float, *, left: float = 0.0, burst: Burst | None = None) -> None:
        self._rate, self._most, self._left, self._since, self._burst = rate, most, left, now, burst

    def charge(self, cost: float, now: float) -> float:
        """Charges work, before it is done. Returns the seconds to wait before doing it."""
        grown = self._left + (now - self._since) * self._rate
        self._left, self._since = min(grown, self._most) - cost, now
        if self._burst is not None:
            self._burst.add(max(0.0, grown - self._most))
            self._left += self._burst.draw(max(0.0, -self._left))
        return max(0.0, -self._left / self._rate)

    def is_full(self, now: float) -> bool:
        """Whether no more can be saved up."""
        return self._left + (now - self._since) * self._rate >= self._most


class SharedAllowances:
    """The allowances of addresses, each shared by all that an address asks for. They begin full.

    Args:
        rate: Growth per second.
        most: The most that can be saved up.
    """

    def __init__(self, rate: float, most: float) -> None:
        self._rate, self._most = rate, most
        self._of: dict[str, Allowance] = {}

    def __len__(self) -> int:
        """The number of addresses whose allowances are remembered."""
        return len(self._of)

    def charge(self, address: str, cost: float, now: float) -> float:
        """Charges an address, as `Allowance.charge` does. Allowances that are full again are forgotten."""
        if address not in self._of:
            self._of = {one: allowance for one, allowance in self._of.items() if not allowance.is_full(now)}
            self._of[address] = Allowance(self._rate, self._most, now, left=self._most)
        return self._of[address].charge(cost, now)


class Allowances:
    """The allowances of all connections. Those of an address share its burst, also with connections that ended."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._bursts: dict[str, Burst] = {}

    def __len__(self) -> int:
        """The number of addresses whose bursts are remembered."""
        return len(self._bursts)

    @contextmanager
    def of(self, address: str, clock: Callable[[], float]) -> Iterator[Allowance]:
        """Opens the allowance of a connection, which begins with nothing of its own."""
        now = clock()
        for whole in [one for one, burst in self._bursts.items() if not burst.connections and burst.left(now) == BURST]:
            del self._bursts[whole]
        burst = self._bursts.setdefault(address, Burst(self._rate, now))
        burst.count(1, now)
        try:
            yield Allowance(self._rate, AT_HAND * self._rate, now, burst=burst)
        finally:
            burst.count(-1, clock())
