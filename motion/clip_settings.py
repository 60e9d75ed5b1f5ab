"""`clips.toml`: what the offline job should know about clips that their files do not say.

[walk_box]
kind = "action"          # or "locomotion", which is what a clip is if nothing is said
neutral = "walk"         # the clip that its posture is relative to
tags = ["carry"]
skip_frames = 1          # leading frames that are not motion, such as a T-pose
unit = "cm"
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from motionsplice.motion.errors import SettingsError, did_you_mean

FILE_NAME = "clips.toml"
KINDS = ("locomotion", "action")


@dataclass(frozen=True)
class ClipSettings:
    """One clip's entry in `clips.toml`."""

    kind: str = "locomotion"
    neutral: str | None = None
    tags: tuple[str, ...] = ()
    skip_frames: int = 0
    unit: str | None = None


DEFAULT_SETTINGS = ClipSettings()


def read_clip_settings(file: Path) -> dict[str, ClipSettings]:
    """The entries of a `clips.toml`, by clip name. Raises SettingsError, naming the clip and the key."""
    try:
        entries = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"it is not TOML: {error}", file=str(file)) from None
    return {name: _settings(name, entry, file) for name, entry in entries.items()}


def _settings(name: str, entry: Any, file: Path) -> ClipSettings:
    where = f"clip {name!r}"
    if not isinstance(entry, Mapping):
        raise SettingsError("it is not a table", file=str(file), place=where, mend=f"Write [{name}]")
    keys = [field.name for field in fields(ClipSettings)]
    for key in entry:
        if key not in keys:
            raise SettingsError(f"unknown key {key!r}", file=str(file), place=where, mend=did_you_mean(key, keys))
    tags = entry.get("tags", [])
    settings = ClipSettings(**{**entry, "tags": tuple(tags) if isinstance(tags, list) else ()})
    wrong = [
        key
        for key, sound in {
            "kind": settings.kind in KINDS,
            "neutral": isinstance(settings.neutral, str | None),
            "tags": isinstance(tags, list) and all(isinstance(tag, str) for tag in settings.tags),
            "skip_frames": type(settings.skip_frames) is int and settings.skip_frames >= 0,
            "unit": isinstance(settings.unit, str | None),
        }.items()
        if not sound
    ]
    if wrong:
        value = entry[wrong[0]]
        raise SettingsError(
            f"{wrong[0]} = {value!r} means nothing",
            file=str(file),
            place=where,
            mend='kind is "locomotion" or "action", neutral and unit are strings, tags strings, skip_frames a count',
        )
    return settings
