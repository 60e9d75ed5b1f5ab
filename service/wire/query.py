"""Query strings, checked by hand: a list of what may be in one says both what is refused and what the schema tells."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote_plus

from motionsplice.motion.errors import did_you_mean
from motionsplice.service.problems import RequestError

REQUIRED = object()


@dataclass(frozen=True)
class Parameter:
    """One parameter of a query: how its text is read, what it is if it is not there, and what the schema says of it."""

    name: str
    read: Callable[[str], Any]
    default: Any
    description: str
    schema: Mapping[str, Any]


def text(name: str, description: str, default: Any = None) -> Parameter:
    return Parameter(name, lambda value: value, default, description, {"type": "string"})


def choice(name: str, description: str, among: Sequence[str], default: str) -> Parameter:
    def read(value: str) -> str:
        if value not in known:
            raise ValueError(f"it is {value[:40]!r}, and should be one of {', '.join(among)}")
        return value

    known = frozenset(among)
    return Parameter(name, read, default, description, {"type": "string", "enum": list(among), "default": default})


def number(
    name: str, description: str, default: Any = None, *, least: float = 0.0, most: float | None = None
) -> Parameter:
    def read(value: str) -> float:
        found = float(value)
        if not math.isfinite(found) or found < least or (most is not None and found > most):
            raise ValueError(f"it is {value[:40]}, and should be {_range(least, most)}")
        return found

    return Parameter(name, read, default, description, {"type": "number", **_bounds(least, most)})


def integer(name: str, description: str, default: Any = None, *, least: int = 0, most: int | None = None) -> Parameter:
    def read(value: str) -> int:
        if not value.isascii() or not value.isdigit() or len(value) > 18:
            raise ValueError(f"it is {value[:40]!r}, and should be a whole number, {_range(least, most)}")
        found = int(value)
        if found < least or (most is not None and found > most):
            raise ValueError(f"it is {found}, and should be {_range(least, most)}")
        return found

    return Parameter(name, read, default, description, {"type": "integer", **_bounds(least, most)})


def _bounds(least: float, most: float | None) -> dict[str, float]:
    return {"minimum": least} if most is None else {"minimum": least, "maximum": most}


def _range(least: float, most: float | None) -> str:
    return f"at least {least:g}" if most is None else f"from {least:g} to {most:g}"


class Query:
    """The parameters that one operation takes."""

    def __init__(self, *parameters: Parameter) -> None:
        self.parameters = {one.name: one for one in parameters}
        self._readers = {one.name: one.read for one in parameters}
        self._defaults = {one.name: one.default for one in parameters}
        self._needed = [one.name for one in parameters if one.default is REQUIRED]

    def read(self, raw: bytes) -> dict[str, Any]:
        """All parameters by name, as given or by default. Raises RequestError for the first that is wrong."""
        values, readers = self._defaults.copy(), self._readers
        seen = set()
        if raw:
            for pair in raw.decode("latin-1").split("&"):
                name, _, value = pair.partition("=")
                if "%" in pair or "+" in pair:
                    name, value = unquote_plus(name), unquote_plus(value)
                if name not in readers:
                    raise RequestError(f"there is no parameter {name[:40]!r}", mend=did_you_mean(name[:40], readers))
                if name in seen:
                    raise RequestError(f"{name}: it is given twice", mend="Give it once")
                seen.add(name)
                try:
                    values[name] = readers[name](value)
                except ValueError as error:
                    raise RequestError(f"{name}: {error}") from None
        for name in self._needed:
            if values[name] is REQUIRED:
                raise RequestError(f"{name}: it is missing", mend=f"Give {self.parameters[name].description}")
        return values
