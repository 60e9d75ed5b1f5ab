"""What a door is: a place where bytes from outside come in, with a generator of inputs that knows their grammar."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from tests.hardening.fuzz.draw import Draw

Files = Mapping[str, bytes]  # an input: its parts by name, which are files for doors that read files

DOORS: Mapping[str, tuple[str, ...]] = {  # with the modules behind them, which fuzzing should cover, by their prefixes
    "bvh": tuple(f"motion.formats.{one}" for one in ("bvh.hierarchy", "bvh.frames", "bvh.reader", "text")),
    "acclaim": ("motion.formats.asf_amc.motion", "motion.formats.asf_amc.skeleton"),
    "gltf": ("motion.formats.gltf.accessors", "motion.formats.gltf.container", "motion.formats.gltf.reader"),
    "toml_files": ("motion.clip_settings", "motion.toml_file", "precompute.hands.settings"),
    "manifest": ("runtime.format.manifest", "runtime.format.checks", "runtime.format.bounded"),
    "tables": ("runtime.format.tables", "runtime.format.checks"),
    "batches": ("service.answers.batch", "service.parsing"),
    "commands": ("service.characters.commands", "service.characters.scene"),
    "heads": ("service.edge.http_protocol", "service.edge.websocket_protocol", "service.edge.hosts"),
}


@dataclass(frozen=True)
class Door:
    """A door.

    Attributes:
        make: Makes an input. Without bytes to choose by, it makes a sound one.
        enter: Sends an input through the door, with an empty folder for its files. Raises MotionError if it is refused.
        early: The problems of inputs that get no further than the first line, or the head.
        per_byte: Bytes of memory that each byte of an input may take, beside 64 MiB.
    """

    make: Callable[[Draw], Files]
    enter: Callable[[Files, Path], None]
    early: re.Pattern[str]
    per_byte: int = 64


def door_of(name: str) -> Door:
    """Returns the door of this name, one of DOORS."""
    door: Door = import_module(f"tests.hardening.fuzz.{name}").DOOR
    return door


def covered_by(name: str, module: str) -> bool:
    """Returns whether a module of the package is behind a door."""
    return module.startswith(tuple(f"motionsplice.{prefix}" for prefix in DOORS[name]))
