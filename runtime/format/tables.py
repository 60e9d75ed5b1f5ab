"""The files of a bank's tables, found and mapped into memory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import BankError
from motionsplice.runtime.format.manifest import REBUILD, TABLES, Manifest

TABLE_FOLDER = "tables"


def table_files(folder: Path, manifest: Manifest) -> dict[str, Path]:
    """Returns the file of each table of the bank in `folder`, by the table's name."""
    return {name: folder / TABLE_FOLDER / f"{Path(manifest.tables[name]).name}.npy" for name in TABLES}


def map_table(name: str, file: Path) -> NDArray[Any]:
    """Maps a table into memory. Raises BankError."""
    try:
        return np.asarray(np.load(file, mmap_mode="r", allow_pickle=False))
    except FileNotFoundError:
        raise BankError(f"table {name!r} is missing", file=str(file), mend=REBUILD) from None
    except Exception as error:  # NumPy parses a damaged header as Python source, which can raise almost anything
        raise BankError(f"table {name!r} is cut short or not an array: {error}", file=str(file), mend=REBUILD) from None
