"""Decorators that compile kernels once, for this processor, into a cache beside them or in NUMBA_CACHE_DIR.

Numba checks only the file of the called kernel to see whether its cache is current. After a change to a kernel that
other kernels call, or to a constant that they import, remove the caches with `make clean`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit  # noqa: TID251  of kernels that are never called from Python
from numpy.typing import NDArray

from motionsplice.motion.kernel_cache import compiled

Array = NDArray[Any]
Index = int | np.uint64  # unsigned, because for signed indices the compiler adds a check for counting from the end
Real = float | np.float32

FASTMATH = {"contract", "reassoc", "arcp", "nsz"}  # without the flag that assumes that there is no NaN
ZERO = np.int64(0)  # a typed zero, because a literal argument makes Numba compile the kernel again

UNCOUNTED: dict[str, Any] = {"_nrt": False}  # kernels create no arrays; reference counting took half the time

kernel = compiled(nogil=True, error_model="numpy", fastmath=FASTMATH, **UNCOUNTED)
parallel_kernel = compiled(nogil=True, error_model="numpy", fastmath=FASTMATH, parallel=True)
# inlined by LLVM: Numba's own inlining infers types again in each caller, and compiling took twice as long
inlined = njit(nogil=True, error_model="numpy", fastmath=FASTMATH, forceinline=True, **UNCOUNTED)
