"""The description of a skeleton that a client needs to pose a rig."""

from __future__ import annotations

from typing import Any

from motionsplice.motion.axes import Axes
from motionsplice.runtime.bank import Bank

DIGITS = 7  # of offsets after the point: finer than float32


def rig_fields(bank: Bank, axes: Axes) -> dict[str, Any]:
    """Returns a bank's joints, the index of each one's parent, offsets in some axes, and the joints of each role."""
    skeleton = bank.skeleton
    return {
        "joints": list(skeleton.names),
        "parents": skeleton.parents.tolist(),
        "offsets": axes.positions(skeleton.offsets).round(DIGITS).tolist(),
        "roles": {role: _named(skeleton.names, joint) for role, joint in vars(bank.roles).items()},
    }


def _named(names: tuple[str, ...], joint: Any) -> str | list[str] | None:
    if isinstance(joint, tuple):
        return [names[one] for one in joint]
    return names[joint] if joint >= 0 else None
