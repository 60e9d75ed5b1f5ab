"""Banks: opened and verified (docs/bank.md)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path

from motionsplice.motion.errors import BankError
from motionsplice.runtime.contents import Contents
from motionsplice.runtime.format.checks import Tables, check_contents, check_fit, check_references
from motionsplice.runtime.format.manifest import MANIFEST, Manifest, manifest_data
from motionsplice.runtime.format.tables import open_tables, table_files


@dataclass(frozen=True, eq=False, repr=False)
class Bank(Contents):
    """All clips of a game character on one skeleton, with the tables that align them.

    Wherever a clip is named, `walk~mirror` names the mirror image of `walk`, which takes no storage.
    A bank is immutable. Its tables are read into memory, or above 64 MiB mapped, so that all processes that open it
    share their pages.

    Attributes:
        path: The bank's folder.
        manifest: Names, entries and digests of everything in the bank.
        tables: The tables by name; `runtime.format.manifest.TABLES` lists shapes and types.

    Example:
        ```python
        from motionsplice import Bank

        bank = Bank.open("demo/bank")
        for clip in bank.clips:
            print(clip.name, clip.kind, f"{clip.duration:.2f} s")
        print(bank.phase("walk")[:3], bank.contacts("walk")[0])
        ```
    """

    path: Path
    manifest: Manifest
    tables: Tables

    @classmethod
    def open(cls, path: str | PathLike[str], *, verify: bool = True) -> Bank:
        """Opens the bank in a folder.

        Without `verify` only the manifest, the headers of mapped tables and one small table are read, so a large bank
        opens at once. Shapes and row numbers are checked in any case: a damaged table can spoil poses, but cannot make
        a kernel read outside the tables. `verify` may be called later.

        Args:
            path: The bank's folder.
            verify: Whether to check the digest and the numbers of every table.

        Raises:
            BankError: The bank is missing, of another version, cut short or altered. Names the file. Its cause is an
                OSError if the bank cannot be read now, though it may be whole.
        """
        folder = Path(path)
        with readable(folder):
            manifest = Manifest.read(folder)
            try:
                tables = open_tables(table_files(folder, manifest))
            except BankError:
                if manifest_data(folder) == manifest.data:
                    raise
                return cls.open(path, verify=verify)  # a job has written another bank, and removed this one's tables
        bank = cls(folder, manifest, tables)
        check_fit(manifest, bank.tables, str(folder / MANIFEST))
        if verify:
            bank.verify()
        else:
            check_references(manifest, bank.tables, bank.files)
        return bank

    def verify(self) -> None:
        """Checks the digest and the numbers of every table, which reads all of them.

        Raises:
            BankError: A table was cut short or altered, or cannot be read. Names the file.
        """
        with readable(self.path):
            check_contents(self.manifest, self.tables, self.files)

    @cached_property
    def files(self) -> dict[str, Path]:
        """The file of each table, by the table's name."""
        return table_files(self.path, self.manifest)

    @property
    def digest(self) -> str:
        """BLAKE2b digest of the manifest's body, in hex. Equal digests mean equal banks."""
        return self.manifest.digest


@contextmanager
def readable(folder: Path) -> Iterator[None]:
    """Raises BankError, whose cause is an OSError, for what the system does not let read."""
    try:
        yield
    except OSError as error:
        mend = "Check the permissions of the folder and its files"
        raise BankError(
            f"it cannot be read: {error.strerror}", file=str(error.filename or folder), mend=mend
        ) from error
