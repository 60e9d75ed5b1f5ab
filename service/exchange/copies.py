"""Copies of a bank's tables, in a folder that only the service writes.

The workers of a service share the copies, and a restart finds them. They are not synced: whoever maps one checks its
digest first.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from motionsplice.motion.errors import BankError, SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import REBUILD, file_digest
from motionsplice.runtime.format.tables import open_tables, table_files

LOCK = ".copies.lock"
READ_ONLY = 0o400


def folder_for(place: str, copies: Path | None) -> Path:
    """Returns the folder for copies of a bank: one of its own for each place, in `copies` or the user's cache.

    Raises SettingsError if there is neither.
    """
    name = hashlib.blake2b(place.encode(), digest_size=8).hexdigest()
    return (copies or _users_cache() / "motionsplice" / "banks") / name


def _users_cache() -> Path:
    if folder := os.environ.get("XDG_CACHE_HOME"):
        return Path(folder)
    try:
        return Path.home() / ".cache"
    except RuntimeError:  # a user without a home, as in a container
        raise SettingsError("this user has no folder for a cache", mend="Set one with --copies") from None


def from_copies(bank: Bank, folder: Path) -> Bank:
    """Returns the bank with its tables opened from copies in a folder, which then has no other tables.

    Copies what is missing or damaged there; one process copies, and the others wait. Raises OSError if a table cannot
    be copied, and BankError if it was altered.
    """
    files = table_files(folder, bank.manifest)
    tables = next(iter(files.values())).parent
    tables.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK).open("ab") as lock:
        fcntl.flock(lock, fcntl.LOCK_SH)
        if not all(_holds(file) for file in files.values()):
            fcntl.flock(lock, fcntl.LOCK_EX)
            _remove_others(tables, files)
            _copy_missing(bank, files)
        return replace(bank, tables=open_tables(files))


def _remove_others(folder: Path, files: Mapping[str, Path]) -> None:
    """Removes the tables of earlier banks, which processes may go on mapping, and what a killed process left."""
    for file in set(folder.iterdir()) - set(files.values()):
        file.unlink()


def _copy_missing(bank: Bank, files: Mapping[str, Path]) -> None:
    for name, file in files.items():
        if not _holds(file):  # another process may have copied it meanwhile
            partial = file.with_suffix(".partial")
            try:
                shutil.copyfile(bank.files[name], partial)
                if file_digest(partial) != file.stem:
                    problem = f"table {name!r} was cut short or altered: its digest does not match"
                    raise BankError(problem, file=str(bank.files[name]), mend=REBUILD)
                partial.chmod(READ_ONLY)
                partial.replace(file)
            finally:
                partial.unlink(missing_ok=True)


def _holds(file: Path) -> bool:
    """Whether a copy is there, and whole. Files of tables are named after their digests."""
    return file.is_file() and file_digest(file) == file.stem
