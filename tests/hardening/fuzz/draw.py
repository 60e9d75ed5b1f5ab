"""Random choices that are read from bytes: a fuzzer that changes the bytes changes the choices."""

from __future__ import annotations

from random import Random

MOST = 9  # oddities of a wild text


class Draw(Random):
    """A source of choices. After the end of its bytes each choice is the first one, which generators make a sound one.

    data: the bytes. Equal bytes give equal choices, and a choice takes the same number of bytes whatever they are, so
    that a change of one byte changes no other choice. The first one says how rare oddities are in this input: an input
    with many of them is refused at the first, and one with few goes far.
    """

    def __new__(cls, data: bytes) -> Draw:
        return super().__new__(cls)

    def __init__(self, data: bytes) -> None:  # the seed of Random is not used
        self._data, self.used = data, 0
        self._calm = 4 ** self._randbelow(6)

    def _randbelow(self, n: int) -> int:  # all methods of Random that choose among n are based on this
        begin = self.used
        self.used = end = begin + (1 if n <= 256 else (n.bit_length() + 7) // 8)
        return int.from_bytes(self._data[begin:end], "little") % n

    def random(self) -> float:
        return self._randbelow(65536) / 65536.0

    def rarely(self, of: int) -> bool:
        """Returns True in one of `of` cases of wild inputs, and less often in calmer ones."""
        return self._randbelow(of * self._calm) == 1

    def few(self) -> int:
        """Returns how many oddities a text has: up to MOST in wild inputs, none in the calmest."""
        return self._randbelow(1 + int(MOST / self._calm**0.5))
