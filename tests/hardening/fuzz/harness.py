"""Sends inputs through a door, each within limits of time and memory, and counts what comes of it."""

from __future__ import annotations

import ctypes
import json
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
M_MMAP_THRESHOLD, LARGE = -3, 128 * 1024
WIDTH = 70  # characters of an outcome


@dataclass
class Tally:
    """What came of inputs: how many there were, how many passed the first line and the whole door, and the outcomes.

    slowest: seconds of processor time. bad: the outcomes that must not be, each with the name of a file with its input.
    """

    inputs: int = 0
    passed_first: int = 0
    passed: int = 0
    slowest: float = 0.0
    outcomes: Counter[str] = field(default_factory=Counter)
    bad: dict[str, str] = field(default_factory=dict)

    def write(self, file: Path) -> None:
        """Writes it as JSON."""
        file.write_text(json.dumps(vars(self)))

    @classmethod
    def read(cls, file: Path) -> Tally:
        """Reads what `write` has written."""
        fields = json.loads(file.read_text())
        return cls(**fields | {"outcomes": Counter(fields["outcomes"])})


class Visitor:
    """Sends inputs through one door.

    saved: the folder for inputs that lead to what must not be, or None. folder: an empty one, whose end the caller sees
    to, for the files of an input; None makes one, which `close` removes.
    """

    def __init__(self, door: Door, saved: Path | None = None, folder: Path | None = None) -> None:
        self.tally = Tally()
        self.door, self._saved = door, saved
        self._folder = folder or Path(tempfile.mkdtemp(dir=IN_MEMORY))
        _return_large_blocks()
        for data in (b"", bytes(range(256))):  # loads what is loaded at first use, and compiles the kernels
            self._outcome(door.make(Draw(data)))

    def close(self) -> None:
        shutil.rmtree(self._folder)

    def visit(self, data: bytes) -> None:
        """Makes an input from bytes, sends it through the door and counts the outcome."""
        files = self.door.make(Draw(data))
        before = time.process_time()
        with _limited(FREE + self.door.per_byte * sum(map(len, files.values()))):
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
            finally:
                for file in self._folder.iterdir():
                    shutil.rmtree(file) if file.is_dir() else file.unlink()
        return "", False

    def _save(self, files: Files, data: bytes) -> str:
        if self._saved is None:
            return data.hex()
        folder = self._saved / f"{len(self.tally.bad)}"
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            (folder / name).write_bytes(content)
        return str(folder)


def write(files: Files, folder: Path) -> None:
    """Writes an input's files to a folder."""
    for name, data in files.items():
        (folder / name).write_bytes(data)


@contextmanager
def _limited(size: int) -> Iterator[None]:
    """Lets this process take `size` bytes of memory more than it has."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    has = int(Path("/proc/self/statm").read_bytes().split()[0]) * PAGE
    resource.setrlimit(resource.RLIMIT_AS, (has + size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _return_large_blocks() -> None:
    """Has freed memory returned at once, or else an input could use what an earlier one took, without counting."""
    ctypes.CDLL(None).mallopt(M_MMAP_THRESHOLD, LARGE)
