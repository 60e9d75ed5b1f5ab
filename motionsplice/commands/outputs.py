"""Checks of the files that commands write."""

from __future__ import annotations

from pathlib import Path

from motionsplice.motion.errors import SettingsError


def check_suffix(file: Path, *suffixes: str, option: str = "--out") -> str:
    """Returns a file's suffix in lower case. Raises SettingsError if it is none of `suffixes`."""
    suffix = file.suffix.lower()
    if suffix not in suffixes:
        known = " or ".join(suffixes)
        raise SettingsError(f"only {known} can be written", file=f"{option} {file}", mend=f"End the name in {known}")
    return suffix
