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
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

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


def write_tables(folder: Path, tables: Mapping[str, Parts]) -> dict[str, str]:
    """Writes tables by name, each from its parts end to end, and returns their digests, after which files are named.

    Only one part is held in memory at a time.
    """
    partials = [folder / f".table.{os.getpid()}.{number}" for number in range(len(tables))]
    with written(folder, *partials):
        digests = {
            name: _write_table(partial, TABLES[name][0], *parts)
            for partial, (name, parts) in zip(partials, tables.items(), strict=True)
        }
        put_tables(folder, dict(zip(partials, digests.values(), strict=True)))
    return digests


def put_tables(folder: Path, partials: Mapping[Path, str]) -> None:
    """Gives written tables their names, by their digests, once they are on the disk."""
    with ThreadPoolExecutor(WAITING) as pool:
        list(pool.map(_sync, partials))
    for partial, digest in partials.items():
        partial.replace(folder / f"{digest}.npy")
    _sync(folder)


def write_synced(file: Path, data: bytes) -> None:
    """Writes a file. Raises BankError."""
    partial = file.with_name(f".{file.name}.{os.getpid()}")
    with written(file.parent, partial):
        partial.write_bytes(data)
        _sync(partial)
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
        mend = "Check the folder's permissions and free space"
        file = str(error.filename or folder)
        raise BankError(f"the bank cannot be written: {error.strerror}", file=file, mend=mend) from None
    finally:
        for partial in partials:
            with suppress(OSError):
                partial.unlink()


def _write_table(file: Path, kind: type, length: int, parts: Iterable[NDArray[Any]]) -> str:
    """Writes a table of `length` rows, and returns its digest."""
    digest = hashlib.blake2b(digest_size=16)
    with file.open("wb") as sink:
        for number, part in enumerate(parts):
            data: NDArray[Any] = np.ascontiguousarray(part, kind)
            if number == 0:
                head, header = io.BytesIO(), np.lib.format.header_data_from_array_1_0(data)
                np.lib.format.write_array_header_1_0(head, header | {"shape": (length, *data.shape[1:])})
                sink.write(head.getvalue())
                digest.update(head.getvalue())
            sink.write(data.data)
            digest.update(data.data)
    return digest.hexdigest()


def _sync(path: Path) -> None:
    """Waits until a file's contents, or a folder's names, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
