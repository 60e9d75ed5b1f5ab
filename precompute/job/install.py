"""Puts a copy of a bank in the place of another that may be in use (docs/operation.md)."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from motionsplice.motion.errors import BankError
from motionsplice.precompute.job.alone import alone_in
from motionsplice.precompute.job.outcome import Progress
from motionsplice.precompute.job.written import (
    make_folder,
    put_tables,
    remove_others,
    tables_in_use,
    write_synced,
    written,
)
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST, file_digest
from motionsplice.runtime.format.tables import TABLE_FOLDER


def install_bank(source: Path, place: Path, progress: Progress) -> str:
    """Copies a bank to the folder `place`, and returns its digest.

    No file changes under its name: tables that are missing or damaged there are put in place by renames, and the
    manifest last. A service that maps the old bank keeps it until it exchanges it.

    Raises:
        BankError: The source is no bank, is damaged or changes meanwhile, or the copy cannot be written.
    """
    bank, manifest = Bank.open(source), (source / MANIFEST).read_bytes()
    names = {file.stem: file for file in bank.files.values()}
    with alone_in(place, progress):
        before, folder = tables_in_use(place / MANIFEST), place / TABLE_FOLDER
        make_folder(folder)
        missing = [digest for digest in names if not _holds(folder / f"{digest}.npy", digest)]
        partials = {folder / f".table.{os.getpid()}.{number}": digest for number, digest in enumerate(missing)}
        with written(folder, *partials):
            for done, (partial, digest) in enumerate(partials.items(), 1):
                shutil.copyfile(names[digest], partial)
                if file_digest(partial) != digest:
                    raise BankError("the bank changed while it was copied", file=str(source), mend="Try again")
                progress("copying", done, len(partials))
            put_tables(folder, partials)
        write_synced(place / MANIFEST, manifest)
        remove_others(place, before | names.keys())
    return bank.digest


def _holds(file: Path, digest: str) -> bool:
    return file.is_file() and file_digest(file) == digest
