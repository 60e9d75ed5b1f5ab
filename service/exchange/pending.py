"""Which clips of a folder are not in the bank as they are: that is the work to do, and all that need be remembered."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from motion.errors import BankError
from motion.formats.files import SUFFIXES
from runtime.manifest import ClipEntry, Manifest, content_digest

SETTINGS_FILE = "clips.toml"


class Folder:
    """A folder of clips. What was digested is not read again until it changes."""

    def __init__(self, clips: Path, bank: Path) -> None:
        self.clips = clips
        self.bank = bank
        self._digests: dict[Path, tuple[tuple[int, int], str]] = {}

    def pending(self) -> dict[str, str]:
        """The clips that the bank has not, or not so: for each a text that changes when it does."""
        said, built = self._said(), self._built()
        waiting = {}
        for file in sorted(self.clips.iterdir()):
            if file.suffix.lower() in SUFFIXES and file.is_file():
                digest, entry = self._digest(file), said.get(file.stem, {})
                if not _is_built(built.get(file.stem), digest, entry):
                    waiting[file.stem] = f"{digest} {sorted(entry.items())}"
        return waiting

    def _digest(self, file: Path) -> str:
        found = file.stat()
        mark = (found.st_mtime_ns, found.st_size)
        known = self._digests.get(file)
        if known is None or known[0] != mark:
            known = self._digests[file] = (mark, content_digest(file.read_bytes()))
        return known[1]

    def _said(self) -> dict[str, Any]:
        try:
            return tomllib.loads((self.clips / SETTINGS_FILE).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}

    def _built(self) -> dict[str, ClipEntry]:
        try:
            return {clip.name: clip for clip in Manifest.read(self.bank).clips}
        except BankError:
            return {}


def _is_built(built: ClipEntry | None, digest: str, said: Any) -> bool:
    if built is None or built.source != digest:
        return False
    kind, tags = said.get("kind", "locomotion"), said.get("tags", [])
    return built.kind == kind and list(built.tags) == tags
