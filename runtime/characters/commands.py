"""What commands to characters say, checked, as numbers of a row."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Limbs
from motionsplice.runtime.requests import known

BLEND = 0.3  # seconds of a fade, unless a command says otherwise

Locomotion = str | Mapping[str, float]


def shares_of(bank: Bank, locomotion: Locomotion) -> dict[int, float]:
    """Weights that come to 1 by clip number. Raises UnknownClipError or SettingsError."""
    given = {locomotion: 1.0} if isinstance(locomotion, str) else dict(locomotion)
    total = sum(given.values())
    if not 1 <= len(given) <= col.MOST_MIXED:
        raise SettingsError(f"{len(given)} locomotions cannot be mixed", mend=f"Name 1 to {col.MOST_MIXED}")
    if not (min(given.values()) >= 0.0 and 0.0 < total < np.inf):
        raise SettingsError("weights should be at least 0, and one of them more")
    return {bank.number(name): weight / total for name, weight in given.items()}


def mask_of(limbs: Limbs, name: str) -> int:
    """The bits of a mask by name. Raises SettingsError if there is none, or the rig lacks its limbs."""
    mask = known(col.MASKS, "mask", name)
    parts = [part for part in range(1, col.PARTS) if mask >> part & 1]
    if mask != col.UPPER_BODY and not limbs.lengths[parts].all():
        raise SettingsError(f"this rig has no {name}", mend="Name the joints of its limbs as roles")
    return mask


def weight_in_range(weight: float) -> float:
    """A weight. Raises SettingsError if it is none."""
    if not 0.0 <= weight <= 1.0:
        raise SettingsError(f"weight {weight} does not lie between 0 and 1")
    return weight


def not_negative(label: str, value: float) -> float:
    """A number of seconds or the like. Raises SettingsError if it is below 0 or no number."""
    if not 0.0 <= value < np.inf:
        raise SettingsError(f"{label} {value} should be a number from 0 on")
    return value
