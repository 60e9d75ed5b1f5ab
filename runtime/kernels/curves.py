"""Curves from 0 to 1."""

from __future__ import annotations

from motionsplice.runtime.simd.compiled import inlined


@inlined
def smooth(t: float) -> float:
    """Returns a step from 0 to 1 without a kink, for t from 0 to 1; held outside."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)
