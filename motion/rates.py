"""Frame rates as people mean them: files round their reciprocals."""

from __future__ import annotations

COMMON = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 144.0, 240.0)
RATES = (*COMMON, *(1000.0 / 1001.0 * rate for rate in (24.0, 30.0, 48.0, 60.0, 120.0, 240.0)))
CLOSE = 1e-4  # relative: what is nearer to a common rate is meant to be that


def common_rate(rate: float) -> float:
    """Returns the common rate nearest to `rate`, in frames per second, or `rate` itself if none is close."""
    nearest = min(RATES, key=lambda one: abs(one - rate))
    return nearest if abs(nearest - rate) <= CLOSE * nearest else rate
