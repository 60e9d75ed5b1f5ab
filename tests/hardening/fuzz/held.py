"""Files whose bytes are in memory: writing, reading and removing a file takes longer than refusing what is in it."""

from __future__ import annotations

import io
from functools import cache
from pathlib import Path, PosixPath

from tests.hardening.fuzz.door import Files


class Held(PosixPath):
    """A file that is read from memory if it has `data`, and else from the disk."""

    data: bytes | None = None

    def read_bytes(self) -> bytes:
        return super().read_bytes() if self.data is None else self.data

    def read_text(self, encoding: str | None = None, errors: str | None = None, newline: str | None = None) -> str:
        return io.TextIOWrapper(io.BytesIO(self.read_bytes()), encoding, errors, newline).read()


def held(files: Files, folder: Path) -> dict[str, Held]:
    """Returns an input's files by name. On the disk they are empty."""
    return {name: _held(folder, name, data) for name, data in files.items()}


def _held(folder: Path, name: str, data: bytes) -> Held:
    file = Held(_on_disk(folder, name))
    file.data = data
    return file


@cache
def _on_disk(folder: Path, name: str) -> Path:
    (folder / name).touch()
    return folder / name
