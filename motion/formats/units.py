"""The units of length of motion files: by name, as a number, or guessed from the legs."""

from __future__ import annotations

import math

from motionsplice.motion.errors import FormatError, SettingsError

GUESSED = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "cmu": 0.0254 / 0.45}
UNITS = GUESSED | {"ft": 0.3048}
LEG = 0.85  # metres from hip over knee to ankle of an adult
GROWN = (0.65, 1.05)  # metres: legs of adults
MOST = 9  # the largest power of ten that is proposed as a unit
POSSIBLE = (0.3, 1.2)  # metres: legs of children too


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


def guess_unit(leg: float) -> tuple[float, str, str]:
    """Guesses the unit in which a leg of length `leg` comes nearest to an adult's.

    Returns the metres in that unit, a note for the user, and a warning, which is empty unless the leg is too short or
    too long for an adult even so. Raises FormatError if the length is not positive.
    """
    if not (math.isfinite(leg) and leg > 0.0):
        problem = "the legs have no length, so the unit of length cannot be guessed"
        raise FormatError(problem, mend="Give the unit with --unit")
    name = min(GUESSED, key=lambda unit: abs(math.log(GUESSED[unit] * leg / LEG)))
    metres = GUESSED[name]
    note = f"assumed unit {name} ({metres:.4g} m), because the legs are {leg:.4g} units long"
    if GROWN[0] <= metres * leg <= GROWN[1]:
        return metres, note, ""
    found = f"legs of {metres * leg:.3g} m, by the assumed unit {name}, do not fit an adult"
    return metres, note, f"{found}. Give {_other_units(metres, leg)}, or --unit {name} if they are right"


def check_stated_unit(metres: float, leg: float) -> list[str]:
    """Returns a warning if a leg of length `leg` does not fit a person in the unit that a file states."""
    if POSSIBLE[0] <= metres * leg <= POSSIBLE[1]:
        return []
    found = f"legs of {metres * leg:.3g} m, by the unit that the file states ({metres:.4g} m), do not fit a person"
    return [f"{found}. Give {_other_units(metres, leg)}, or --unit {metres:.9g} if they are right"]


def _other_units(metres: float, leg: float) -> str:
    """Returns the options for units other than `metres` in which a leg may be a person's."""
    exponent = round(math.log10(LEG) - math.log10(leg))
    power = f"{10.0 ** min(max(exponent, -MOST), MOST):.0e}"  # of ten, if no unit with a name fits
    for units in (UNITS, {power: float(power)}):
        possible = {name: unit * leg for name, unit in units.items() if POSSIBLE[0] <= unit * leg <= POSSIBLE[1]}
        if others := [name for name in possible if units[name] != metres]:
            return " or ".join(f"--unit {name} for legs of {possible[name]:.2g} m" for name in others)
    return "another --unit"
