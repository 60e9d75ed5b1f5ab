"""Random choices that are read from bytes: a fuzzer that changes the bytes changes the choices."""

from __future__ import annotations

from random import Random


class Draw(Random):
    """A source of choices. After the end of its bytes each choice is the first one, which generators make a sound one.

    data: the bytes. Equal bytes give equal choices. The first one says how rare oddities are in this input: an input
    with many of them is refused at the first, and one with few goes far.
    """

    def __init__(self, data: bytes) -> None:
        super().__init__(0)
        self._data, self._at = data, 0
        self._calm = 4 ** self.randrange(6)

    def getrandbits(self, k: int, /) -> int:
        size = (k + 7) // 8
        piece = self._data[self._at : self._at + size]
        self._at += size
        return int.from_bytes(piece, "little") & ((1 << k) - 1)

    def random(self) -> float:
        return self.getrandbits(16) / 65536.0

    def rarely(self, of: int) -> bool:
        """Returns True in one of `of` cases of wild inputs, and less often in calmer ones."""
        return self.randrange(of * self._calm) == 1
