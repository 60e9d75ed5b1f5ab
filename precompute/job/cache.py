"""What the offline job has worked out before, on disk under digests of all that it was worked out from.

An entry is one `.npz` file: named arrays, and `said`, a MessagePack map of the rest. Whatever is wrong with an entry,
it is only made again. The folder may be deleted at any time.
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
ABANDONED = 3600.0  # seconds after which no job is still writing a file

Said = dict[str, Any]
Arrays = Mapping[str, NDArray[Any]]
Made = TypeVar("Made")


def key_of(*parts: Any) -> str:
    """The digest of what MessagePack can hold."""
    return content_digest(msgpack.packb(parts))


def digest_of_array(values: Floats) -> str:
    return key_of(str(values.dtype), values.shape, np.ascontiguousarray(values).tobytes())


@dataclass(frozen=True)
class Cache:
    """Entries in one folder, which is made by the first."""

    folder: Path

    def holds(self, key: str) -> bool:
        return self._file(key).exists()

    def load(self, key: str, unpack: Callable[[Said, Arrays], Made]) -> Made | None:
        """What `unpack` makes of an entry, of which it reads what it asks for.

        None if there is none, or if it is damaged or another's.
        """
        try:
            with np.load(self._file(key), allow_pickle=False) as archive:
                return unpack(msgpack.unpackb(archive["said"].tobytes()), archive)
        except Exception:  # whatever is wrong with it, it can be made again
            return None

    def store(self, key: str, said: Said, arrays: Arrays) -> None:
        """Writes an entry, whole or not at all. Raises MotionError if the disk does not take it."""
        partial = self.folder / f".{key}.npz.{os.getpid()}"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with partial.open("wb") as sink:
                np.savez(sink, allow_pickle=False, said=np.frombuffer(msgpack.packb(said), np.uint8), **arrays)
            partial.replace(self._file(key))
        except OSError as error:
            with suppress(OSError):
                partial.unlink()
            raise MotionError(f"results cannot be kept: {error.strerror}", file=str(self.folder)) from None

    def keep_only(self, keys: Collection[str]) -> None:
        """Removes all other entries, and what killed jobs left half written."""
        names = {self._file(key).name for key in keys}
        for file in self.folder.iterdir():
            unused = OURS.fullmatch(file.name) and file.name not in names
            with suppress(FileNotFoundError):  # another job may be at it
                if unused or (OUR_PARTIAL.fullmatch(file.name) and time.time() - file.stat().st_mtime > ABANDONED):
                    file.unlink()

    def _file(self, key: str) -> Path:
        return self.folder / f"{key}.npz"
