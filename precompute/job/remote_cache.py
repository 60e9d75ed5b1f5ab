"""The offline job's cache at a URL: one object for each entry, written whole (docs/cluster.md)."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from contextlib import suppress
from functools import cached_property
from io import BufferedIOBase, BytesIO
from pathlib import Path
from uuid import uuid4

from motionsplice.motion.errors import MotionError
from motionsplice.motion.storage.place import read_ahead
from motionsplice.motion.storage.remote import Remote, StorageError
from motionsplice.precompute.job.cache import OURS, Arrays, Cache, CacheError, Fields, write_entry


class RemoteCache(Cache):
    """Entries at a URL. The coordinator lists it once, and has copies in a folder; other processes keep none."""

    def __init__(self, remote: Remote, copies: Path | None) -> None:
        super().__init__(copies or Path())
        self._remote, self._copies = remote, copies

    def __reduce__(self) -> tuple[type[RemoteCache], tuple[Remote, None]]:
        return RemoteCache, (self._remote, None)

    @property
    def place(self) -> str:
        return str(self._remote)

    def holds(self, key: str) -> bool:
        return f"{key}.entry" in self._listed

    def read_ahead(self, keys: Iterable[str]) -> None:
        """Copies entries, many at a time."""
        missing = [key for key in keys if not self._copied(key)]
        read_ahead(self._try_to_copy, missing, lambda _: self._remote)

    def store(self, key: str, fields: Fields, arrays: Arrays) -> None:
        entry = BytesIO()
        write_entry(entry, fields, arrays)
        try:
            (self._remote / f"{key}.entry").write_bytes(entry.getvalue())
            if self._copies is not None:
                self._put(key, entry.getvalue())
        except MotionError as error:
            raise CacheError(f"cannot write to the cache: {error.problem}", file=self.place, mend=error.mend) from None
        except OSError as error:
            problem, mend = f"cannot copy the cache here: {error.strerror}", "Set TMPDIR to a folder with enough space"
            raise CacheError(problem, file=str(self._copies), mend=mend) from None

    def keep_only(self, keys: Collection[str]) -> None:
        """Removes all other entries."""
        names = {f"{key}.entry" for key in keys}
        with suppress(StorageError):  # the next job removes them
            now = Remote(self._remote.url).listed()  # with those that workers have written
            self._remote.remove([name for name in now if OURS.fullmatch(name) and name not in names])

    @cached_property
    def _listed(self) -> Collection[str]:
        return self._remote.listed()

    def _open(self, key: str) -> BufferedIOBase:
        if self._copies is None:
            return BytesIO(self._read(key))
        if not self._copied(key):
            self._put(key, self._read(key))
        return super()._open(key)

    def _copied(self, key: str) -> bool:
        return super().holds(key)

    def _try_to_copy(self, key: str) -> None:
        with suppress(OSError, MotionError):  # it is made again when it is loaded
            self._put(key, self._read(key))

    def _read(self, key: str) -> bytes:
        return (self._remote / f"{key}.entry").read_bytes()

    def _put(self, key: str, data: bytes) -> None:
        partial = self.folder / uuid4().hex
        self.folder.mkdir(parents=True, exist_ok=True)
        partial.write_bytes(data)
        partial.replace(self._file(key))
