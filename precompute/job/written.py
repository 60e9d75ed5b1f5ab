"""Files of a bank, written whole or not at all, so that a power cut leaves the old bank or the new one.

A name must never survive without what it stands for. So contents are synced before files get their names, and the
tables' names before the manifest's, which makes them current. All tables wait for the disk at the same time: a file
system commits them together.
"""

from __future__ import annotations

import hashlib
import io
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from os.path import exists
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import BankError
from motionsplice.runtime.format.bounded import unpacked
from motionsplice.runtime.format.manifest import MANIFEST, TABLES
from motionsplice.runtime.format.tables import TABLE_FOLDER

WAITING = 4  # files synced at once: more threads take longer to start than they save
OUR_TABLE = re.compile(r"[0-9a-f]{32}")  # other files in the folder are never removed
OUR_PARTIAL = re.compile(rf"\.(table|{re.escape(MANIFEST)})(\.\d+)+")

Parts = tuple[int, Iterable[NDArray[Any]]]  # the number of rows, and the rows in pieces of any size
Piece = Mapping[str, NDArray[Any]]  # rows by the name of their table


def write_tables(folder: Path, tables: Mapping[str, Parts]) -> dict[str, str]:
    """Writes tables by name, each from its parts end to end, and returns their digests, after which files are named.

    Only one part is held in memory at a time.
    """
    lengths = {name: length for name, (length, _) in tables.items()}
    return write_rows(folder, lengths, ({name: part} for name, (_, parts) in tables.items() for part in parts))


def write_rows(folder: Path, lengths: Mapping[str, int], pieces: Iterable[Piece]) -> dict[str, str]:
    """Writes tables side by side, as `write_tables` does. Each piece has the next rows of one table or of several.

    lengths: the number of rows of each table, which must have one piece at least.
    """
    partials = [folder / f".table.{os.getpid()}.{number}" for number in range(len(lengths))]
    with written(folder, *partials):
        with ExitStack() as files:
            opened = zip(partials, lengths.items(), strict=True)
            tables = {name: _Table(files.enter_context(file.open("wb")), name, rows) for file, (name, rows) in opened}
            for piece in pieces:
                for name, part in piece.items():
                    tables[name].append(part)
        digests = {name: table.digest.hexdigest() for name, table in tables.items()}
        put_tables(folder, dict(zip(partials, digests.values(), strict=True)))
    return digests


def put_tables(folder: Path, partials: Mapping[Path, str]) -> None:
    """Gives written tables their names, by their digests, once they are on the disk."""
    with ThreadPoolExecutor(WAITING) as pool:
        list(pool.map(_sync, partials))
    for partial, digest in partials.items():
        partial.replace(folder / f"{digest}.npy")
    _sync(folder)


def make_folder(folder: Path) -> None:
    """Makes a folder, and those above it, if they are missing. Raises BankError."""
    missing = [one for one in (folder, *folder.parents) if not exists(one)]
    with written(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for one in missing:
            _sync(one.parent)


def write_synced(file: Path, data: bytes) -> None:
    """Writes a file, whose name is on the disk after all other names in its folder. Raises BankError."""
    partial = file.with_name(f".{file.name}.{os.getpid()}")
    with written(file.parent, partial):
        partial.write_bytes(data)
        _sync(partial)
        _sync(file.parent)
        partial.replace(file)
        _sync(file.parent)


def tables_in_use(manifest: Path) -> set[str]:
    """Returns the table digests of the bank about to be replaced; empty if it is missing or damaged."""
    try:
        return set(unpacked(unpacked(manifest.read_bytes())["body"])["tables"].values())
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return set()


def remove_others(path: Path, tables: Collection[str]) -> None:
    """Removes all other tables of the bank in the folder `path`, and partial files of killed jobs.

    What cannot be removed stays: the bank is in place already. No other job may be at work on the folder.
    """
    folder = path / TABLE_FOLDER
    for file in (*path.iterdir(), *folder.iterdir()):
        old = file.suffix == ".npy" and OUR_TABLE.fullmatch(file.stem) and file.stem not in tables
        if (old and file.parent == folder) or OUR_PARTIAL.fullmatch(file.name):
            with suppress(OSError):
                file.unlink()


@contextmanager
def written(folder: Path, *partials: Path) -> Iterator[None]:
    """Names what cannot be written in a folder, and removes partial files that were not renamed. Raises BankError."""
    try:
        yield
    except OSError as error:
        file = str(error.filename or folder)
        raise BankError(f"the bank cannot be written: {error.strerror}", file=file, mend=mend_of(error)) from None
    finally:
        for partial in partials:
            with suppress(OSError):
                partial.unlink()


def mend_of(error: OSError) -> str:
    """Returns what to do about a folder that cannot be written."""
    if isinstance(error, FileExistsError | NotADirectoryError):
        return "A file or a broken link is in the folder's place: name another folder, or remove it"
    return "Check the folder's permissions and free space"


class _Table:
    """A table of `length` rows that is being written."""

    def __init__(self, sink: BinaryIO, name: str, length: int) -> None:
        self._sink, self._kind, self._length, self._begun = sink, TABLES[name][0], length, False
        self.digest = hashlib.blake2b(digest_size=16)

    def append(self, part: NDArray[Any]) -> None:
        data: NDArray[Any] = np.ascontiguousarray(part, self._kind)
        if not self._begun:
            head, header = io.BytesIO(), np.lib.format.header_data_from_array_1_0(data)
            np.lib.format.write_array_header_1_0(head, header | {"shape": (self._length, *data.shape[1:])})
            self._write(head.getbuffer())
            self._begun = True
        self._write(data.data)

    def _write(self, data: memoryview) -> None:
        self._sink.write(data)
        self.digest.update(data)


def _sync(path: Path) -> None:
    """Waits until a file's contents, or a folder's names, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
