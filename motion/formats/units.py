"""The units of length of motion files: by name, as a number, or guessed from the legs."""

from __future__ import annotations

import math

from motionsplice.motion.errors import FormatError, SettingsError

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "cmu": 0.0254 / 0.45}
LEG = 0.85  # metres from hip over knee to ankle of an adult


def metres_per_unit(unit: str) -> float:
    """Returns the metres in a unit given by name or as a number. Raises SettingsError for anything else."""
    try:
        metres = UNITS[unit] if unit in UNITS else float(unit)
    except ValueError:
        metres = math.nan
    if not (math.isfinite(metres) and metres > 0.0):
        mend = f"Use {', '.join(UNITS)}, or the metres per unit as a number"
        raise SettingsError(f"{unit!r} is not a unit of length", mend=mend)
    return metres


def guess_unit(leg: float) -> tuple[float, str]:
    """Guesses the unit in which a leg of length `leg` comes nearest to an adult's.

    Returns the metres in that unit and a note for the user. Raises FormatError if the length is not positive.
    """
    if not (math.isfinite(leg) and leg > 0.0):
        problem = "the legs have no length, so the unit of length cannot be guessed"
        raise FormatError(problem, mend="Give the unit with --unit")
    name = min(UNITS, key=lambda unit: abs(math.log(UNITS[unit] * leg / LEG)))
    note = f"assumed unit {name} ({UNITS[name]:.4g} m), because the legs are {leg:.4g} units long"
    return UNITS[name], note
