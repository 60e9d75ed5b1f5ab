"""Which clip files the offline job is to read, and what is said of each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from motionsplice.motion.clip_settings import FILE_NAME, ClipSettings, read_clip_settings
from motionsplice.motion.errors import ClipError, SettingsError, did_you_mean
from motionsplice.motion.formats.files import SUFFIXES, clip_files


@dataclass(frozen=True)
class Source:
    """One clip file, its settings, and the roles that are given rather than found."""

    file: Path
    settings: ClipSettings
    roles: Mapping[str, str | Sequence[str]]

    @property
    def name(self) -> str:
        return self.file.stem


def find_sources(
    paths: Iterable[Path], roles: Mapping[str, str | Sequence[str]], default: ClipSettings
) -> list[Source]:
    """The clip files behind `paths` (files, or folders of them), in order of name.

    A clip of which a `clips.toml` beside it says nothing has the `default` settings.

    Raises ClipError if there are none, or two of one name; SettingsError for a bad `clips.toml`.
    """
    files: dict[str, Path] = {}
    for path in paths:
        if not path.exists():
            raise ClipError("there is no such file or folder", file=str(path))
        for file in clip_files(path) if path.is_dir() else [path]:
            if files.setdefault(file.stem, file).resolve() != file.resolve():
                twins = f"{files[file.stem]} and {file}"
                raise ClipError(f"two clips are called {file.stem!r}: {twins}", mend="Rename one of them")
    if not files:
        raise ClipError("there are no clips here", mend=f"Give files or folders of {', '.join(sorted(SUFFIXES))}")
    settings: dict[str, ClipSettings] = {}
    for folder in sorted({file.parent for file in files.values()}):
        if (folder / FILE_NAME).is_file():
            settings |= _settings_of(folder)
    return [Source(files[name], settings.get(name, default), roles) for name in sorted(files)]


def _settings_of(folder: Path) -> dict[str, ClipSettings]:
    settings, names = read_clip_settings(folder / FILE_NAME), [file.stem for file in clip_files(folder)]
    for name in settings:
        if name not in names:
            problem = f"there is no clip {name!r} beside it"
            raise SettingsError(problem, file=str(folder / FILE_NAME), mend=did_you_mean(name, names))
    return settings
