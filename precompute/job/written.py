"""Files of a bank, written whole or not at all, so that a power cut leaves the old bank or the new one.

A name must never survive without what it stands for. So contents are synced before files get their names, and the
tables' names before the manifest's, which makes them current. All tables wait for the disk at the same time: a file
system commits them together.
"""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.format.manifest import TABLES

Parts = tuple[int, Iterable[NDArray[Any]]]  # the number of rows, and the rows in pieces of any size


def write_tables(folder: Path, tables: Mapping[str, Parts]) -> dict[str, str]:
    """Writes tables by name, each from its parts end to end, and returns their digests, after which files are named.

    Only one part is held in memory at a time.
    """
    partials = [folder / f".table.{os.getpid()}.{number}" for number in range(len(tables))]
    digests = {
        name: _write_table(partial, TABLES[name][0], *parts)
        for partial, (name, parts) in zip(partials, tables.items(), strict=True)
    }
    with ThreadPoolExecutor(len(partials)) as pool:
        list(pool.map(_sync, partials))
    for partial, digest in zip(partials, digests.values(), strict=True):
        partial.replace(folder / f"{digest}.npy")
    _sync(folder)
    return digests


def write_synced(file: Path, data: bytes) -> None:
    """Writes a file."""
    partial = file.with_name(f".{file.name}.{os.getpid()}")
    partial.write_bytes(data)
    _sync(partial)
    partial.replace(file)
    _sync(file.parent)


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
