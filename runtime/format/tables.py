"""The files of a bank's tables, found and opened."""

from __future__ import annotations

import mmap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from motionsplice.motion.errors import BankError
from motionsplice.runtime.format.manifest import REBUILD, TABLES, Manifest

TABLE_FOLDER = "tables"
SMALL = 64 * 2**20  # bytes of all tables together


def table_files(folder: Path, manifest: Manifest) -> dict[str, Path]:
    """Returns the file of each table of the bank in `folder`, by the table's name."""
    return {name: folder / TABLE_FOLDER / f"{Path(manifest.tables[name]).name}.npy" for name in TABLES}


def open_tables(files: Mapping[str, Path]) -> dict[str, NDArray[Any]]:
    """Opens all tables of a bank, read-only. Raises BankError, or OSError if a file cannot be read.

    A SMALL bank is read into memory. Larger ones are mapped, so that processes share their pages; but who cuts a mapped
    file short while it is in use kills these processes, unless they lease it, as the service does.
    """
    small = sum(file.stat().st_size for file in files.values() if file.exists()) <= SMALL
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
    """Reads a table into pages of its own, which are aligned as those of a mapped file."""
    with file.open("rb", buffering=0) as source:
        pages = mmap.mmap(-1, max(1, file.stat().st_size))
        source.readinto(pages)
    if npy.read_magic(pages) != (1, 0):
        raise ValueError("expected version 1.0 of the npy format")
    shape, fortran_order, dtype = npy.read_array_header_1_0(pages)
    if fortran_order:
        raise ValueError("expected rows in C order")
    table = np.frombuffer(pages, dtype, count=int(np.prod(shape, dtype=object)), offset=pages.tell()).reshape(shape)
    table.flags.writeable = False
    return table
