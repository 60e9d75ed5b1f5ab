"""Arrays between pages that nobody may touch: reading outside them ends the process (SIGSEGV), in compiled code too."""

from __future__ import annotations

import ctypes
import mmap
from typing import Any

import numpy as np
from numpy.typing import NDArray

PAGE, ALIGNED = mmap.PAGESIZE, 64
PROT_NONE = 0


def guarded(table: NDArray[Any]) -> NDArray[Any]:
    """Returns a copy of a table that ends at most 63 bytes before a guarded page, and begins after another.

    It is aligned as a table of a bank is. The bytes between its end and the page are not zero.
    """
    size = -(-max(table.nbytes, 1) // ALIGNED) * ALIGNED
    pages = -(-size // PAGE)
    area = mmap.mmap(-1, (pages + 2) * PAGE)
    area[:] = b"\xa5" * len(area)
    begin = (1 + pages) * PAGE - size
    copy = np.frombuffer(area, table.dtype, table.size, begin).reshape(table.shape)
    copy[...] = table
    address = ctypes.addressof(ctypes.c_char.from_buffer(area))
    for page in (0, 1 + pages):
        if ctypes.CDLL(None, use_errno=True).mprotect(ctypes.c_void_p(address + page * PAGE), PAGE, PROT_NONE):
            raise OSError(ctypes.get_errno(), "mprotect")
    return copy
