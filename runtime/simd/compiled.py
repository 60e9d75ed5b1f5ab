"""How kernels are compiled: once, into a cache beside them or in NUMBA_CACHE_DIR, for this processor.

Numba looks only at the file of the kernel that is called for whether its cache is of today: after a change to a kernel
that others call, remove the caches (`make clean` does).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]
Index = int | np.uint64  # signed indices may count from the end, and the compiler then guards each of them
Real = float | np.float32

FASTMATH = {"contract", "reassoc", "arcp", "nsz"}  # not what takes NaN for impossible
ZERO = np.int64(0)  # to begin counting from: kernels are compiled apart for each literal that they are given

UNCOUNTED: dict[str, Any] = {"_nrt": False}  # kernels make no arrays; counting references to them took half the time

kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH, **UNCOUNTED)
parallel_kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH, parallel=True)
# by LLVM, once it is lowered: where Numba itself inlines, it infers types anew in each caller, and took twice as long
inlined = njit(nogil=True, error_model="numpy", fastmath=FASTMATH, forceinline=True, **UNCOUNTED)
