"""The frames of one splice, evaluated in blocks, so that other requests are served in between."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Memory, Poses
from motionsplice.runtime.splice import Splice
from motionsplice.service.problems import LimitError, RequestError
from motionsplice.service.serving import Edition
from motionsplice.service.wire.parameters import splice_of
from motionsplice.service.wire.query import integer, number

BLOCK = 256  # frames that are evaluated at once, in a tenth of a millisecond
WHICH = (
    number("rate", "frames per second; default: those of the clip", least=0.001, most=1000.0),
    integer("first", "number of the first frame", 0, most=10**9),
    integer("count", "number of frames; default: all", least=1, most=10**9),
)


@dataclass(frozen=True)
class Frames:
    """A range of a splice's frames: `count` frames from `first` on, `rate` per second of the locomotion."""

    edition: Edition
    splice: Splice
    rate: float
    first: int
    count: int

    @classmethod
    def from_query(cls, edition: Edition, values: dict[str, Any], most: int) -> Frames:
        """Returns the frames of a query, whose first one is evaluated as a check. Raises MotionError."""
        clip = edition.bank.clip(values["locomotion"])
        rate, first = values["rate"] or clip.rate, values["first"]
        whole = int(clip.duration * rate + 1e-6) + 1
        if first >= whole:
            raise RequestError(f"first: frame {first} is after the last, {whole - 1}", mend="Frames count from 0")
        count = min(values["count"] or whole, whole - first)
        if count > most or (values["posture"] == "running" and first + count > most):
            problem = f"{count} frames from frame {first} on exceed the {most} frames of one answer"
            raise LimitError(problem, mend="Ask for a part with first and count, or for a lower rate")
        frames = cls(edition, splice_of(values), rate, first, count)
        frames._evaluated(frames._times(0, 1), Memory.begin(1, rate))
        return frames

    def blocks(self, size: int) -> Iterator[tuple[int, Poses]]:
        """Yields the number of each block's first frame, and its poses, at most `size`."""
        memory, last = Memory.begin(1, self.rate), self.first + self.count
        if self.splice.posture == "running":  # it depends on all earlier frames
            for first in range(0, self.first, BLOCK):
                self._evaluated(self._times(first, min(first + BLOCK, self.first)), memory)
        for first in range(self.first, last, size):
            yield first, self._evaluated(self._times(first, min(first + size, last)), memory)

    @property
    def evaluator(self) -> Evaluator:
        return self.edition.evaluator

    def _times(self, first: int, end: int) -> NDArray[np.float64]:
        return np.minimum(np.arange(first, end) / self.rate, self.edition.bank.clip(self.splice.locomotion).duration)

    def _evaluated(self, times: NDArray[np.float64], memory: Memory) -> Poses:
        return self.evaluator.sequence(self.splice, times, memory=memory)
