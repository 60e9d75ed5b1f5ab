"""What an upload says of its clip, written into `clips.toml`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import tomlkit
from tomlkit.exceptions import TOMLKitError

from motionsplice.motion.clip_settings import DEFAULT_SETTINGS, FILE_NAME, ClipSettings, read_clip_settings
from motionsplice.motion.errors import SettingsError


@dataclass(frozen=True)
class Said:
    """What `clips.toml` is to say of a clip; None leaves what it says."""

    kind: str | None = None
    neutral: str | None = None
    tags: tuple[str, ...] | None = None


def settings_of(file: Path, clip: str) -> ClipSettings:
    """What a `clips.toml` says of a clip. Raises SettingsError."""
    return _read(file).get(clip, DEFAULT_SETTINGS) if file.exists() else DEFAULT_SETTINGS


def written_beside(file: Path, clip: str, said: Said) -> Path:
    """A new `clips.toml` beside the old, synced, that says this of a clip, and all else as the old does.

    Raises SettingsError if the old is none.
    """
    fresh = file.with_name(f".{file.name}.new")
    try:
        document = tomlkit.parse(file.read_text(encoding="utf-8")) if file.exists() else tomlkit.document()
        entry = document.setdefault(clip, tomlkit.table())
        for key, value in (("kind", said.kind), ("neutral", said.neutral), ("tags", said.tags)):
            if value is not None:
                entry[key] = list(value) if isinstance(value, tuple) else value
    except (TOMLKitError, UnicodeDecodeError, TypeError) as error:
        raise SettingsError(f"it is not as it should be: {error}", file=file.name, mend="Mend it by hand") from None
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
    """Raises SettingsError that names no folder, for it is told to clients."""
    try:
        return read_clip_settings(file)
    except SettingsError as error:
        raise SettingsError(error.problem, file=FILE_NAME, place=error.place, mend=error.mend) from None
