"""The files of a bank's tables, found and opened."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from motionsplice.motion.errors import BankError
from motionsplice.runtime.format.manifest import REBUILD, TABLES, Manifest, mark_of
from motionsplice.runtime.format.rows import LINE

TABLE_FOLDER = "tables"
SMALL = 64 * 2**20  # bytes of all tables together
ALIGNMENT = 4 * LINE  # bytes


def table_files(folder: Path, manifest: Manifest) -> dict[str, Path]:
    """Returns the file of each table of the bank in `folder`, by the table's name."""
    tables = folder / TABLE_FOLDER
    return {name: tables / f"{manifest.tables[name]}.npy" for name in TABLES}


def open_tables(files: Mapping[str, Path]) -> dict[str, NDArray[Any]]:
    """Opens all tables of a bank, read-only. Raises BankError, or OSError if a file cannot be read.

    A SMALL bank is read into memory. Larger ones are mapped, so that processes share their pages; but who cuts a mapped
    file short while it is in use kills these processes, unless they lease it, as the service does.
    """
    small = sum(mark[-1] for file in files.values() if (mark := mark_of(file))) <= SMALL
    return {name: _opened(name, file, small) for name, file in files.items()}


def _opened(name: str, file: Path, small: bool) -> NDArray[Any]:
    try:
        return _read(file) if small else np.asarray(np.load(file, mmap_mode="r", allow_pickle=False))
    except FileNotFoundError:
        raise BankError(f"table {name!r} is missing", file=str(file), mend=REBUILD) from None
    except OSError:  # it may be whole
        raise
    except Exception as error:  # NumPy parses a damaged header as Python source, which can raise almost anything
        raise BankError(f"table {name!r} is cut short or not an array: {error}", file=str(file), mend=REBUILD) from None


def _read(file: Path) -> NDArray[Any]:
    """Reads a table into memory that begins at a whole line of the cache, as a mapped file does."""
    with file.open("rb", buffering=0) as source:
        size = os.fstat(source.fileno()).st_size
        memory = np.empty(size + ALIGNMENT, np.uint8)
        contents = memory[-memory.ctypes.data % ALIGNMENT :][:size]
        contents = contents[: source.readinto(contents.data)]  # it may have been cut short meanwhile
        source.seek(0)
        if npy.read_magic(source) != (1, 0):
            raise ValueError("expected version 1.0 of the npy format")
        shape, fortran_order, dtype = npy.read_array_header_1_0(source)
        offset = source.tell()
    if fortran_order:
        raise ValueError("expected rows in C order")
    table = np.frombuffer(contents, dtype, count=math.prod(shape), offset=offset).reshape(shape)
    table.flags.writeable = False
    return table
