"""Writes the settings of an uploaded clip into `clips.toml`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import tomlkit
from tomlkit.exceptions import TOMLKitError

from motionsplice.motion.clip_settings import DEFAULT_SETTINGS, FILE_NAME, ClipSettings, read_clip_settings
from motionsplice.motion.errors import SettingsError


@dataclass(frozen=True)
class EntryUpdate:
    """Changes to a clip's entry of `clips.toml`. None leaves a key as it is."""

    kind: str | None = None
    neutral: str | None = None
    tags: tuple[str, ...] | None = None


def settings_of(file: Path, clip: str) -> ClipSettings:
    """Returns a clip's settings in a `clips.toml`, or the default ones. Raises SettingsError."""
    return _read(file).get(clip, DEFAULT_SETTINGS) if file.exists() else DEFAULT_SETTINGS


def written_beside(file: Path, clip: str, update: EntryUpdate) -> Path:
    """Writes and syncs a copy of a `clips.toml` with a clip's entry updated. Returns its path, beside the old file.

    Everything else stays as it is, comments included. Raises SettingsError if the old file is not valid.
    """
    fresh = file.with_name(f".{file.name}.new")
    try:
        document = tomlkit.parse(file.read_text(encoding="utf-8")) if file.exists() else tomlkit.document()
        table = document.setdefault(clip, tomlkit.table())
        for key, value in (("kind", update.kind), ("neutral", update.neutral), ("tags", update.tags)):
            if value is not None:
                table[key] = list(value) if isinstance(value, tuple) else value
    except (TOMLKitError, UnicodeDecodeError, TypeError) as error:
        raise SettingsError(f"the file is not valid: {error}", file=file.name, mend="Correct it by hand") from None
    with fresh.open("w", encoding="utf-8") as sink:
        sink.write(tomlkit.dumps(document))
        sink.flush()
        os.fsync(sink.fileno())
    try:
        _read(fresh)
    except SettingsError:
        fresh.unlink()
        raise
    return fresh


def _read(file: Path) -> dict[str, ClipSettings]:
    """Reads a `clips.toml`. Raises SettingsError without the folder's name, as clients see the message."""
    try:
        return read_clip_settings(file)
    except SettingsError as error:
        raise SettingsError(error.problem, file=FILE_NAME, place=error.place, mend=error.mend) from None
