"""The result of a parser."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from motionsplice.motion.formats.fold import Nodes
from motionsplice.motion.roles import NOTHING_GIVEN


class Parsed(NamedTuple):
    """The contents of a file: joints over time, frames per second, and optionally its unit (metres), roles and notes.

    warnings: what is probably wrong with the file, such as a header that disagrees with the frames.
    up: the axis that is up by the format's definition, None if the format does not define it.
    """

    nodes: Nodes
    rate: float
    unit: float | None = None
    roles: Mapping[str, str] = NOTHING_GIVEN  # type: ignore[assignment]
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    up: str | None = None
