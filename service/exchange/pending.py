"""Finds the clips of a folder that are not in the bank, or that differ from it."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

from motionsplice.motion.clip_settings import (
    DEFAULT_SETTINGS,
    FILE_NAME,
    ClipSettings,
    read_clip_settings,
    settings_for,
)
from motionsplice.motion.errors import BankError, FormatError, SettingsError
from motionsplice.motion.formats.files import clip_files, clips_in, files_behind
from motionsplice.runtime.format.entries import ClipEntry
from motionsplice.runtime.format.manifest import MANIFEST, Manifest, Mark, file_digest, mark_of


class Folder:
    """A folder of clips and the bank built from it. Files are digested again only when they change."""

    def __init__(self, clips: Path, bank: Path) -> None:
        self.clips = clips
        self.bank = bank
        self._clips: dict[Path, tuple[Mark | None, tuple[str, ...]]] = {}
        self._digests: dict[Path, tuple[Mark | None, str]] = {}
        self._read: tuple[Mark | None, Manifest | None] = (None, None)

    @property
    def manifest(self) -> Manifest | None:
        """The bank's manifest, or None without a bank. It is read only when it changes, as a large one takes long."""
        mark = mark_of(self.bank / MANIFEST)
        if mark != self._read[0]:
            try:
                self._read = mark, Manifest.read(self.bank)
            except BankError:
                self._read = mark, None
        return self._read[1]

    def pending(self) -> dict[str, str]:
        """Returns the clips and hands that are new or changed, each with a text that changes when it changes again."""
        settings, built, hands = self._settings(), self._built(), self._hands()
        waiting = {}
        for file in clip_files(self.clips):
            if file.is_file():
                digests = self._digests_behind(file)
                for name in self._names(file):
                    entry = settings_for(name, settings, DEFAULT_SETTINGS)
                    if hands.get(name) != digests[0] and not _is_built(built.get(name), digests[0], entry):
                        waiting[name] = f"{' '.join(digests)} {astuple(entry)}"
        return waiting

    def missing(self) -> list[str]:
        """Returns the clips and hands of the bank that are not in the folder. A new bank would not have them."""
        present = {name for file in clip_files(self.clips) for name in self._names(file)}
        return sorted((self._built().keys() | self._hands()) - present)

    def _names(self, file: Path) -> tuple[str, ...]:
        """Returns the names of a file's clips."""
        mark = mark_of(file)
        known = self._clips.get(file)
        if known is None or known[0] != mark:
            try:
                names = tuple(clips_in(file))
            except FormatError:  # the job reports it
                names = (file.stem,)
            known = self._clips[file] = (mark, names)
        return known[1]

    def _digests_behind(self, file: Path) -> list[str]:
        try:
            return [self._digest(one) for one in files_behind(file)]
        except FormatError:  # its skeleton is missing
            return [self._digest(file)]

    def _digest(self, file: Path) -> str:
        mark = mark_of(file)
        known = self._digests.get(file)
        if known is None or known[0] != mark:
            known = self._digests[file] = (mark, file_digest(file))
        return known[1]

    def _settings(self) -> dict[str, ClipSettings]:
        try:
            return read_clip_settings(self.clips / FILE_NAME)
        except (OSError, SettingsError):  # the job reports it
            return {}

    def _built(self) -> dict[str, ClipEntry]:
        return {clip.name: clip for clip in self.manifest.clips} if self.manifest else {}

    def _hands(self) -> dict[str, str]:
        """Returns the digest of each hands clip of the bank."""
        return {one.name: one.source for one in self.manifest.hands} if self.manifest else {}


def _is_built(built: ClipEntry | None, digest: str, settings: ClipSettings) -> bool:
    return built is not None and (built.source, built.kind, built.tags) == (digest, settings.kind, settings.tags)
