from contextlib import contextmanager
from typing import Any


class _N:
    def inc(self, n: float = 1) -> None: ...
    def observe(self, n: float) -> None: ...


class Metrics:
    def __init__(self) -> None:
        self.frames_sent = _N()
        self.frames_skipped = _N()
        self.tick_lateness = _N()
        self.evaluation = _N()

    @contextmanager
    def connection(self, kind: str) -> Any:
        yield

    def count(self, route: str, status: int) -> None: ...
    def render(self) -> Any:
        return b"", "text/plain"
