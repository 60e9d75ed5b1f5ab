"""What a door is: a place where bytes from outside come in, with a generator of inputs that knows their grammar."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from tests.hardening.fuzz.draw import Draw

Files = Mapping[str, bytes]  # an input: its parts by name, which are files for doors that read files

DOORS = ("bvh", "acclaim", "gltf", "toml_files", "manifest", "tables", "batches", "commands", "heads")


@dataclass(frozen=True)
class Door:
    """A door.

    Attributes:
        covered: Prefixes of the modules behind the door, whose coverage is shown.
        make: Makes an input. Without bytes to choose by, it makes a sound one.
        enter: Sends an input through the door, with an empty folder for its files. Raises MotionError if it is refused.
        early: The problems of inputs that get no further than the first line, or the head.
        per_byte: Bytes of memory that each byte of an input may take, beside 64 MiB.
    """

    covered: tuple[str, ...]
    make: Callable[[Draw], Files]
    enter: Callable[[Files, Path], None]
    early: re.Pattern[str]
    per_byte: int = 64


def door_of(name: str) -> Door:
    """Returns the door of this name, one of DOORS."""
    door: Door = import_module(f"tests.hardening.fuzz.{name}").DOOR
    return door
