"""Names that come twice in a file."""

from __future__ import annotations

from collections.abc import Sequence


def numbered(names: Sequence[str]) -> tuple[str, ...]:
    """Returns different names: of several that are equal, the second "Tip" becomes "Tip.001", as in Blender.

    No new name is one that occurs elsewhere in `names`.
    """
    taken, unique = set(names), list[str]()
    counts: dict[str, int] = {}  # numbers given to each name
    for name in names:
        free = name
        if name in counts:
            while free in taken:
                counts[name] += 1
                free = f"{name}.{counts[name]:03d}"
            taken.add(free)
        else:
            counts[name] = 0
        unique.append(free)
    return tuple(unique)
