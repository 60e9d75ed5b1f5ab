"""The offline job's cache: results on disk, each under the digest of everything it depends on.

An entry is one `.npz` file: named arrays, and `fields`, a MessagePack map of everything else. A damaged entry is made
again. The folder may be deleted at any time.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import msgpack
import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import MotionError
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.format.manifest import content_digest

OURS = re.compile(r"[0-9a-f]{32}\.npz")
OUR_PARTIAL = re.compile(r"\.[0-9a-f]{32}\.npz\.\d+")
ABANDONED = 3600.0  # seconds after which a partial file is left over from a killed job

Fields = dict[str, Any]  # what MessagePack can hold, beside the arrays of an entry
Arrays = Mapping[str, NDArray[Any]]
Result = TypeVar("Result")


def key_of(*parts: Any) -> str:
    """Returns the digest of values that MessagePack can hold."""
    return content_digest(msgpack.packb(parts))


def digest_of_array(values: Floats) -> str:
    """Returns the digest of an array: its type, shape and values."""
    return key_of(str(values.dtype), values.shape, np.ascontiguousarray(values).tobytes())


@dataclass(frozen=True)
class Cache:
    """Entries in one folder, which the first entry creates."""

    folder: Path

    def holds(self, key: str) -> bool:
        """Returns whether an entry exists. It may still be damaged."""
        return self._file(key).exists()

    def load(self, key: str, unpack: Callable[[Fields, Arrays], Result]) -> Result | None:
        """Returns what `unpack` makes of an entry. Only the arrays that `unpack` uses are read.

        Returns None if the entry is missing, damaged, or of another kind.
        """
        try:
            with np.load(self._file(key), allow_pickle=False) as archive:
                return unpack(msgpack.unpackb(archive["fields"].tobytes()), archive)
        except Exception:  # any damaged entry can be made again
            return None

    def store(self, key: str, fields: Fields, arrays: Arrays) -> None:
        """Writes an entry, whole or not at all. Raises MotionError if it cannot be written."""
        partial = self.folder / f".{key}.npz.{os.getpid()}"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with partial.open("wb") as sink:
                np.savez(sink, allow_pickle=False, fields=np.frombuffer(msgpack.packb(fields), np.uint8), **arrays)
            partial.replace(self._file(key))
        except OSError as error:
            with suppress(OSError):
                partial.unlink()
            problem = f"cannot write to the cache: {error.strerror}"
            mend = "Check the folder's permissions and free space"
            raise MotionError(problem, file=str(self.folder), mend=mend) from None

    def keep_only(self, keys: Collection[str]) -> None:
        """Removes all other entries, and partial files of killed jobs."""
        names = {self._file(key).name for key in keys}
        for file in self.folder.iterdir():
            unused = OURS.fullmatch(file.name) and file.name not in names
            with suppress(FileNotFoundError):  # another job may have removed it
                if unused or (OUR_PARTIAL.fullmatch(file.name) and time.time() - file.stat().st_mtime > ABANDONED):
                    file.unlink()

    def _file(self, key: str) -> Path:
        return self.folder / f"{key}.npz"
