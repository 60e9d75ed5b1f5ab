"""How kernels are compiled: once, into a cache beside them or in NUMBA_CACHE_DIR, for this processor.

Numba looks only at the file of the kernel that is called for whether its cache is of today: after a change to a kernel
that others call, remove the caches (`make clean` does).
"""

from __future__ import annotations

from numba import njit

FASTMATH = {"contract", "reassoc", "arcp", "nsz"}  # not what takes NaN for impossible

kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH)
parallel_kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH, parallel=True)
inlined = njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH, inline="always")
