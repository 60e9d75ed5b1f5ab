"""Units of length of motion files."""

from __future__ import annotations

import math

from motionsplice.motion.errors import FormatError, SettingsError

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "cmu": 0.0254 / 0.45}
LEG = 0.85  # metres from hip over knee to ankle of a grown person


def metres_per_unit(unit: str) -> float:
    """The metres in a unit given by name or as a number. Raises SettingsError."""
    try:
        metres = UNITS[unit] if unit in UNITS else float(unit)
    except ValueError:
        metres = math.nan
    if not (math.isfinite(metres) and metres > 0.0):
        raise SettingsError(f"{unit!r} is no unit of length", mend=f"Use {', '.join(UNITS)}, or metres per unit")
    return metres


def guess_unit(leg: float) -> tuple[float, str]:
    """The metres in the unit in which a leg of that length is most like a person's, and a note that says so."""
    if not (math.isfinite(leg) and leg > 0.0):
        raise FormatError("its legs have no length, so its unit cannot be guessed", mend="Give --unit")
    name = min(UNITS, key=lambda unit: abs(math.log(UNITS[unit] * leg / LEG)))
    note = f"its unit was taken for {name} ({UNITS[name]:.4g} m), for its legs are {leg:.4g} units long"
    return UNITS[name], note
