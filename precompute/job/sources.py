"""The clip files that the offline job reads, with their settings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from motionsplice.motion.clip_settings import FILE_NAME, ClipSettings, read_clip_settings
from motionsplice.motion.errors import ClipError, SettingsError, did_you_mean
from motionsplice.motion.formats.files import SUFFIXES, clip_files


@dataclass(frozen=True)
class Source:
    """A clip file, its settings, and the roles that the user gave. The other roles are found from the rig."""

    file: Path
    settings: ClipSettings
    roles: Mapping[str, str | Sequence[str]]

    @property
    def name(self) -> str:
        return self.file.stem


def find_sources(
    paths: Iterable[Path], roles: Mapping[str, str | Sequence[str]], default: ClipSettings
) -> list[Source]:
    """Returns the clip files in `paths` (files, or folders of files), in order of name.

    Settings are those of the `clips.toml` beside a clip, or `default` if the file does not list the clip.

    Raises ClipError if there are no clips, or two of one name; SettingsError for a bad `clips.toml`.
    """
    files: dict[str, Path] = {}
    for path in paths:
        if not path.exists():
            raise ClipError("file or folder not found", file=str(path))
        for file in clip_files(path) if path.is_dir() else [path]:
            if files.setdefault(file.stem, file).resolve() != file.resolve():
                twins = f"{files[file.stem]} and {file}"
                raise ClipError(f"two clips are named {file.stem!r}: {twins}", mend="Rename one of them")
    if not files:
        raise ClipError("no clips found", mend=f"Name files or folders of {', '.join(sorted(SUFFIXES))}")
    settings: dict[str, ClipSettings] = {}
    for folder in sorted({file.parent for file in files.values()}):
        if (folder / FILE_NAME).is_file():
            settings |= _settings_of(folder)
    return [Source(files[name], settings.get(name, default), roles) for name in sorted(files)]


def _settings_of(folder: Path) -> dict[str, ClipSettings]:
    """Reads a folder's `clips.toml`. Raises SettingsError if it is bad, or lists a clip that is not in the folder."""
    settings, names = read_clip_settings(folder / FILE_NAME), [file.stem for file in clip_files(folder)]
    for name in settings:
        if name not in names:
            problem = f"clip {name!r} not found in its folder"
            raise SettingsError(problem, file=str(folder / FILE_NAME), mend=did_you_mean(name, names))
    return settings
