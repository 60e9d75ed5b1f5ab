"""The compiled form of a kernel, for calls without Numba's look-up of the arguments' types.

The look-up takes 0.2 microseconds of a call. Without it nothing checks types, so check arrays before.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def entry_of(kernel: Any, *arguments: Any) -> Callable[..., Any]:
    """Returns a kernel compiled for arguments of these types, which must be those of all calls: also in their layout.

    An array that is not writable may be passed for one that is, if the kernel only reads it.
    """
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return kernel
    types = tuple(numba.typeof(one) for one in arguments)  # type: ignore[no-untyped-call]
    return kernel.compile(types)
