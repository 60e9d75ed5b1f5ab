"""Sends inputs through a door, each within limits of time and memory, and counts what comes of it."""

from __future__ import annotations

import ctypes
import gc
import json
import os
import re
import resource
import shutil
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from motionsplice.motion.errors import MotionError
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw
from tests.hardening.memory import IN_MEMORY

MOST_SECONDS = 1.0  # of the processor for an input
FREE = 64 * 2**20  # bytes of memory that an input of any size may take
PAGE = resource.getpagesize()
M_MMAP_THRESHOLD, LARGE = -3, 2**20
WIDTH = 70  # characters of an outcome


@dataclass
class Tally:
    """What came of inputs: how many there were, how many passed the first line and the whole door, and the outcomes.

    repeated: how many more were made that the same process had sent through the door before. slowest, seconds: of
    processor time, of an input and of all with the fuzzer. memory: bytes that the process has taken since the first
    input, at most, of which an input has taken less. bad: the outcomes that must not be, each with the name of a file
    with its input.
    """

    inputs: int = 0
    repeated: int = 0
    passed_first: int = 0
    passed: int = 0
    slowest: float = 0.0
    seconds: float = 0.0
    memory: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    bad: dict[str, str] = field(default_factory=dict)

    def write(self, file: Path) -> None:
        """Writes it as JSON."""
        file.write_text(json.dumps(vars(self)))

    @classmethod
    def read(cls, file: Path) -> Tally:
        """Reads what `write` has written. Without a file there were no inputs."""
        if not file.exists():
            return cls()
        fields = json.loads(file.read_text())
        return cls(**fields | {"outcomes": Counter(fields["outcomes"])})


class Visitor:
    """Sends inputs through one door.

    saved: the folder for inputs that lead to what must not be, or None. folder: an empty one, whose end the caller sees
    to, for the files of inputs; None makes one, which `close` removes. tally: of earlier inputs, to count on. used: the
    bytes from which the last input was made.
    """

    def __init__(
        self, door: Door, saved: Path | None = None, folder: Path | None = None, tally: Tally | None = None
    ) -> None:
        self.tally = tally or Tally()
        self.door, self._saved = door, saved
        self._folder = folder or Path(tempfile.mkdtemp(dir=IN_MEMORY))
        self._memory = Memory()
        self._seen = set[int]()  # the hashes of inputs
        self.used = b""
        for data in (b"", bytes(range(256))):  # loads what is loaded at first use, and compiles the kernels
            self._outcome(door.make(Draw(data)))
        gc.collect()
        gc.freeze()  # what is loaded stays: the collector need not look at it again and again

    def close(self) -> None:
        gc.unfreeze()
        self._memory.close()
        shutil.rmtree(self._folder)

    def visit(self, data: bytes) -> bool:
        """Makes an input from bytes, sends it through the door and counts the outcome. Returns whether it is new.

        An input that was sent before only counts as repeated.
        """
        draw = Draw(data)
        files = self.door.make(draw)
        self.used = data[: draw.used]
        if (key := hash(tuple(files.items()))) in self._seen:
            self.tally.repeated += 1
            return False
        self._seen.add(key)
        before = time.process_time()
        with self._memory.limited(FREE + self.door.per_byte * sum(map(len, files.values()))):
            problem, is_bad = self._outcome(files)
        taken = time.process_time() - before
        if taken > MOST_SECONDS:
            problem, is_bad = f"slow: {problem}", True
        tally = self.tally
        tally.inputs += 1
        tally.slowest = max(tally.slowest, taken)
        tally.passed += not problem
        tally.passed_first += not self.door.early.match(problem)
        words = re.sub(r"'[^']*'|\"[^\"]*\"|-?\d[\w.+-]*", "…", problem)[:WIDTH] if not is_bad else problem
        tally.outcomes[words or "passed"] += 1
        if is_bad and words not in tally.bad:
            tally.bad[words] = self._save(files, data)
        return True

    def _outcome(self, files: Files) -> tuple[str, bool]:
        """Returns the problem of an input, empty if there is none, and whether it is a bug."""
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                self.door.enter(files, self._folder)
            except MotionError as error:
                str(error).encode()  # as printing does
                return error.problem or "a problem without words", not error.problem
            except Exception as error:
                frame = traceback.extract_tb(error.__traceback__)[-1]
                place = f"{Path(frame.filename).name}, line {frame.lineno}"
                return f"{type(error).__name__} in {place}: {str(error)[:WIDTH]}", True
        return "", False

    def _save(self, files: Files, data: bytes) -> str:
        if self._saved is None:
            return data.hex()
        folder = self._saved / f"{len(self.tally.bad)}"
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            (folder / name).write_bytes(content)
        return str(folder)


class Memory:
    """Limits the memory that this process may take."""

    def __init__(self) -> None:
        # Has freed memory returned at once, or else an input could use what an earlier one took, without counting.
        ctypes.CDLL(None).mallopt(M_MMAP_THRESHOLD, LARGE)
        self._soft, self._hard = resource.getrlimit(resource.RLIMIT_AS)
        self._taken = os.open("/proc/self/statm", os.O_RDONLY)  # opening it takes longer than reading it

    @contextmanager
    def limited(self, size: int) -> Iterator[None]:
        """Lets this process take `size` bytes of memory more than it has."""
        has = int(os.pread(self._taken, 64, 0).split()[0]) * PAGE
        resource.setrlimit(resource.RLIMIT_AS, (has + size, self._hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_AS, (self._soft, self._hard))

    def close(self) -> None:
        os.close(self._taken)
