"""Frame rates as people mean them: files round their reciprocals."""

from __future__ import annotations

from decimal import Decimal

COMMON = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 144.0, 240.0)
RATES = (*COMMON, *(1000.0 / 1001.0 * rate for rate in (24.0, 30.0, 48.0, 60.0, 120.0, 240.0)))
CLOSE = 1e-4  # relative: what is nearer to a common rate is meant to be that
FARTHEST = 0.05  # relative: the last digit of a frame time of one digit may stand for far more
FLOAT32 = 1e-7  # relative: what single precision may change


def common_rate(rate: float) -> float:
    """Returns the common rate nearest to `rate`, in frames per second, or `rate` itself if none is close."""
    nearest = min(RATES, key=lambda one: abs(one - rate))
    return nearest if abs(nearest - rate) <= CLOSE * nearest else rate


def meant_rate(step: str) -> float:
    """Returns the frames per second that the digits of a frame time mean, such as 60 for "0.017".

    Common rates come first: within CLOSE, or within the last digit and FARTHEST, rounded better than truncated. Then
    whole rates that give these digits.
    """
    seconds, digit = float(step), 10.0 ** float(Decimal(step).as_tuple().exponent)

    apart = {rate: abs(1.0 / rate - seconds) for rate in RATES}
    rounded = max(0.5 * digit, CLOSE * seconds)
    near = [rate for rate in RATES if apart[rate] < max(rounded, min(digit, FARTHEST * seconds))]
    if near:
        return min(near, key=lambda rate: (apart[rate] > rounded, rate not in COMMON, apart[rate]))
    whole = float(round(1.0 / seconds))
    return whole if whole > 0.0 and abs(1.0 / whole - seconds) < max(digit, FLOAT32 * seconds) else 1.0 / seconds
