"""Puts a copy of a bank in the place of another that may be in use (docs/operation.md)."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from motionsplice.motion.errors import BankError, MotionError
from motionsplice.motion.storage.place import Place
from motionsplice.motion.storage.remote import Remote, StorageError
from motionsplice.precompute.job.alone import alone_in
from motionsplice.precompute.job.outcome import Progress
from motionsplice.precompute.job.written import (
    OUR_TABLE,
    make_folder,
    put_tables,
    remove_others,
    tables_in_use,
    write_synced,
    written,
)
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST, Manifest, file_digest
from motionsplice.runtime.format.tables import TABLE_FOLDER


@dataclass(frozen=True)
class Offered:
    """A bank that can be copied: its manifest, and what copies the table of a digest to a file."""

    manifest: Manifest
    copy: Callable[[str, Path], object]


def install_bank(
    source: Path | Remote, place: Path | Remote, progress: Progress = lambda stage, done, total: None
) -> str:
    """Copies a bank from a folder or URL to another, and returns its digest.

    No file changes under its name: tables that are missing or damaged there are put in place by renames, and the
    manifest last. A service that maps the old bank keeps it until it exchanges it.

    Raises:
        BankError: The source is no bank, is damaged or changes meanwhile, or the copy cannot be written.
        StorageError: A URL cannot be used.
    """
    if isinstance(place, Path):
        return _install(_offered(source), source, place, progress)
    if isinstance(source, Path):
        return publish_bank(source, place, progress)
    with TemporaryDirectory(prefix="motionsplice-") as name:
        _install(_offered(source), source, Path(name), progress)
        return publish_bank(Path(name), place, progress)


def publish_bank(source: Path, place: Remote, progress: Progress) -> str:
    """Copies a bank to a URL, where only tables that are missing are written, and the manifest last."""
    bank, there = Bank.open(source), Remote(place.url) / TABLE_FOLDER
    before, listed = _tables_at(place), there.listed()
    missing = [file for file in bank.files.values() if not _is_there(file, there)]
    for done, file in enumerate(missing, 1):
        (there / file.name).upload(file)
        progress("copying", done, len(missing))
    (place / MANIFEST).write_bytes(bank.manifest.data)
    kept = before | {file.name for file in bank.files.values()}
    with suppress(StorageError):  # the bank is in place; the next one's job removes them
        there.remove([name for name in listed if OUR_TABLE.fullmatch(name.removesuffix(".npy")) and name not in kept])
    return bank.digest


def published(place: Remote, digest: str) -> bool:
    """Whether the bank of this digest is at a URL, with all its tables."""
    try:
        manifest = _manifest_at(place)
    except MotionError:
        return False
    there = (Remote(place.url) / TABLE_FOLDER).listed()
    return manifest.digest == digest and {f"{table}.npy" for table in manifest.tables.values()} <= there.keys()


def _install(offered: Offered, source: Place, place: Path, progress: Progress) -> str:
    digests = set(offered.manifest.tables.values())
    with alone_in(place, progress):
        before, folder = tables_in_use(place / MANIFEST), place / TABLE_FOLDER
        make_folder(folder)
        missing = sorted(digest for digest in digests if not _holds(folder / f"{digest}.npy", digest))
        partials = {folder / f".table.{os.getpid()}.{number}": digest for number, digest in enumerate(missing)}
        with written(folder, *partials):
            for done, (partial, digest) in enumerate(partials.items(), 1):
                if not _copied(offered, digest, partial):
                    raise BankError("the bank changed while it was copied", file=str(source), mend="Try again")
                progress("copying", done, len(partials))
            put_tables(folder, partials)
        write_synced(place / MANIFEST, offered.manifest.data)
        remove_others(place, before | digests)
    return offered.manifest.digest


def _offered(source: Path | Remote) -> Offered:
    """Returns a bank to copy. Raises BankError for a bad manifest, and on this machine for a damaged table."""
    if isinstance(source, Path):
        bank = Bank.open(source)
        names = {file.stem: file for file in bank.files.values()}
        return Offered(bank.manifest, lambda digest, file: shutil.copyfile(names[digest], file))
    tables = source / TABLE_FOLDER
    return Offered(_manifest_at(source), lambda digest, file: (tables / f"{digest}.npy").download(file))


def _manifest_at(place: Remote) -> Manifest:
    try:
        data = (place / MANIFEST).read_bytes()
    except FileNotFoundError:
        mend = "Build one with `motionsplice precompute CLIPS... --out URL`"
        raise BankError("there is no bank", file=str(place), mend=mend) from None
    return Manifest.parse(data, str(place / MANIFEST))


def _tables_at(place: Remote) -> set[str]:
    """Returns the names of the tables of the bank about to be replaced; empty if it is missing or damaged."""
    try:
        return {f"{table}.npy" for table in _manifest_at(place).tables.values()}
    except BankError:
        return set()


def _is_there(file: Path, folder: Remote) -> bool:
    found = folder.listed().get(file.name)
    return found is not None and found.size == file.stat().st_size


def _copied(offered: Offered, digest: str, file: Path) -> bool:
    """Copies a table. Returns whether it was there, whole."""
    try:
        offered.copy(digest, file)
    except FileNotFoundError:
        return False
    return file_digest(file) == digest


def _holds(file: Path, digest: str) -> bool:
    return file.is_file() and file_digest(file) == digest
