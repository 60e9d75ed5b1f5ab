"""Checks query strings. One list of parameters defines both what is accepted and the OpenAPI schema."""

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
    """One parameter of a query: its parser, its default, and its entry in the schema.

    `read` raises ValueError with a sentence about the value.
    """

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
            raise ValueError(f"expected one of {', '.join(among)}, found {value[:40]!r}")
        return value

    known = frozenset(among)
    return Parameter(name, read, default, description, {"type": "string", "enum": list(among), "default": default})


def flag(name: str, description: str) -> Parameter:
    values = {"true": True, "false": False}

    def read(value: str) -> bool:
        if value not in values:
            raise ValueError(f"expected true or false, found {value[:40]!r}")
        return values[value]

    return Parameter(name, read, False, description, {"type": "boolean", "default": False})


def number(
    name: str, description: str, default: Any = None, *, least: float = 0.0, most: float | None = None
) -> Parameter:
    def read(value: str) -> float:
        try:
            found = float(value)
        except ValueError:
            found = math.nan
        if not math.isfinite(found) or found < least or (most is not None and found > most):
            raise ValueError(f"expected a number {_range(least, most)}, found {value[:40]!r}")
        return found

    return Parameter(name, read, default, description, {"type": "number", **_bounds(least, most)})


def integer(name: str, description: str, default: Any = None, *, least: int = 0, most: int | None = None) -> Parameter:
    def read(value: str) -> int:
        is_number = value.isascii() and value.isdigit() and len(value) <= 18
        if not is_number or int(value) < least or (most is not None and int(value) > most):
            raise ValueError(f"expected a whole number {_range(least, most)}, found {value[:40]!r}")
        return int(value)

    return Parameter(name, read, default, description, {"type": "integer", **_bounds(least, most)})


def _bounds(least: float, most: float | None) -> dict[str, float]:
    return {"minimum": least} if most is None else {"minimum": least, "maximum": most}


def _range(least: float, most: float | None) -> str:
    return f"of at least {least:g}" if most is None else f"from {least:g} to {most:g}"


class Query:
    """The parameters of one operation."""

    def __init__(self, *parameters: Parameter) -> None:
        self.parameters = {one.name: one for one in parameters}
        self._readers = {one.name: one.read for one in parameters}
        self._defaults = {one.name: one.default for one in parameters}
        self._needed = [one.name for one in parameters if one.default is REQUIRED]

    def read(self, raw: bytes) -> dict[str, Any]:
        """Returns all parameters by name, with defaults for those not given. Raises RequestError."""
        values, readers = self._defaults.copy(), self._readers
        seen = set()
        if raw:
            for pair in raw.decode("latin-1").split("&"):
                name, _, value = pair.partition("=")
                if "%" in pair or "+" in pair:
                    name, value = unquote_plus(name), unquote_plus(value)
                if name not in readers:
                    raise RequestError(f"unknown parameter {name[:40]!r}", mend=did_you_mean(name[:40], readers))
                if name in seen:
                    raise RequestError(f"{name}: given twice", mend="Give it once")
                seen.add(name)
                try:
                    values[name] = readers[name](value)
                except ValueError as error:
                    raise RequestError(f"{name}: {error}") from None
        for name in self._needed:
            if values[name] is REQUIRED:
                raise RequestError(f"{name}: missing", mend=f"Give {name}, the {self.parameters[name].description}")
        return values
