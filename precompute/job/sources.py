"""The clip files that the offline job reads, with their settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache

from motionsplice.motion.clip_settings import FILE_NAME, ClipSettings, read_clip_settings, settings_for
from motionsplice.motion.errors import ClipError, FormatError, SettingsError, did_you_mean, listed
from motionsplice.motion.formats.files import SUFFIXES, clip_files, clips_in, other_files
from motionsplice.motion.roles import GivenRole
from motionsplice.motion.storage.place import Place, exists, is_dir, is_named, read_ahead, resolved
from motionsplice.precompute.preparation.cuts import Cut
from motionsplice.runtime.format.manifest import MANIFEST
from motionsplice.runtime.mirrored import MIRRORED


@dataclass(frozen=True)
class Source:
    """A clip of a file, and its settings.

    animation: which of a file's several animations it is, or None. cut: which stretch of a hybrid it is, or None.
    """

    name: str
    file: Place
    animation: str | None
    settings: ClipSettings
    cut: Cut | None = None


def find_sources(paths: Iterable[Place], roles: Mapping[str, GivenRole], default: ClipSettings) -> list[Source]:
    """Returns the clips in `paths` (files, or folders of files), in order of name.

    Settings are those of the `clips.toml` beside a clip, and `default` for all that it leaves out. Clips without roles
    of their own get `roles`.

    Raises ClipError if there are no clips, two of one name, or one with a mirror image's name; SettingsError for a bad
    `clips.toml`.
    """
    found: dict[str, tuple[Place, str | None]] = {}
    paths = list(paths)
    files, others = list[Place](), list[str]()
    for path in paths:
        if not exists(path):
            raise ClipError("file or folder not found", file=str(path))
        others += [file.name for file in other_files(path)] if is_dir(path) else []
        files += clip_files(path) if is_dir(path) else [path]
    read = dict(zip(files, read_ahead(_clips_of, files, lambda file: file), strict=True))
    clips_of = cache(lambda file: read[file] if file in read else _clips_of(file))  # each file is read once
    for file in files:
        for name, animation in (clips_of(file) or {file.stem: None}).items():  # an unread file fails under its name
            if not _is_unicode(name):
                problem = f"no clip can be named {name!r}: that is not UTF-8, and a bank cannot store it"
                raise ClipError(problem, file=ascii(str(file)), mend="Rename the file, or its animation")
            if name.endswith(MIRRORED):
                problem = f"no clip can be named {name!r}: that is the mirror image of another"
                raise ClipError(problem, file=str(file), mend="Rename the file")
            other, _ = found.setdefault(name, (file, animation))
            if resolved(other) != resolved(file):
                raise ClipError(f"two clips are named {name!r}: {other} and {file}", mend="Rename one of them")
    if not found and others:
        raise ClipError(f"no clips found, and these cannot be read: {listed(others)}", mend="Export them as BVH or GLB")
    if not found:
        raise _nothing_in(paths)
    settings: dict[str, ClipSettings] = {}
    for folder in sorted({file.parent for file, _ in found.values()}):
        if is_named(folder / FILE_NAME):  # a link that leads nowhere is an error, as its settings would be missing
            settings |= _settings_of(folder, clips_of, default)
    sources = [Source(name, *found[name], settings_for(name, settings, default)) for name in sorted(found)]
    return [replace(one, settings=replace(one.settings, roles=one.settings.roles or roles)) for one in sources]


def _is_unicode(name: str) -> bool:
    """Whether a name is text. Those of files are bytes, and JSON may have half of a surrogate pair."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _nothing_in(paths: list[Place]) -> ClipError:
    folders = [str(path) for path in paths]
    if any(exists(path / MANIFEST) for path in paths):
        mend = "Name the folder of the clips that it was built from"
        return ClipError("this is a bank, not a folder of clips", file=", ".join(folders), mend=mend)
    mend = f"Name files or folders of {', '.join(sorted(SUFFIXES))}; their subfolders are not searched"
    return ClipError("no clips found", file=", ".join(folders), mend=mend)


def _clips_of(file: Place) -> dict[str, str | None] | None:
    """Returns the clips of a file, or None for a file that cannot be read."""
    try:
        return clips_in(file)
    except FormatError:
        return None


def _settings_of(
    folder: Place, clips_of: Callable[[Place], Mapping[str, str | None] | None], default: ClipSettings
) -> dict[str, ClipSettings]:
    """Reads a folder's `clips.toml`. Raises SettingsError if it is bad, or lists a clip that is not in the folder."""
    settings = read_clip_settings(folder / FILE_NAME, default)
    names, unread = set[str](), set[str]()
    for file in clip_files(folder):
        clips = clips_of(file)
        if clips is None:  # the clip fails, not the job
            unread.add(file.stem)
        else:
            names |= {file.stem, *clips}
    for name in settings:
        if name not in names and name.partition(":")[0] not in unread:
            problem = f"clip {name!r} not found in its folder"
            raise SettingsError(problem, file=str(folder / FILE_NAME), mend=did_you_mean(name, names))
    return settings
