"""The offline job's cache: results on disk, each under the digest of everything it depends on.

An entry is one file: a head, and then the bytes of named arrays. The head is a MessagePack map of the `fields`, which
are everything else, and of what the arrays are, with checksums. A damaged entry is made again, and nothing is allocated
for what it does not hold. The folder may be deleted at any time.
"""

from __future__ import annotations

import math
import os
import re
import struct
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from io import SEEK_END, BufferedIOBase
from pathlib import Path
from typing import Any, BinaryIO, TypeVar
from uuid import uuid4

import msgpack
import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import MotionError
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.job.written import mend_of
from motionsplice.runtime.format.manifest import content_digest

OURS = re.compile(r"[0-9a-f]{32}\.(entry|npz)")  # .npz: of earlier versions
OUR_PARTIAL = re.compile(r"\.[0-9a-f]{32}\.(entry|npz)\.\w+")
START = struct.Struct("<8sII")  # MAGIC, bytes of the head, their CRC-32
MAGIC = b"MSENTRY1"
KINDS = "fiu"  # of NumPy: floats and whole numbers

Fields = dict[str, Any]  # what MessagePack can hold, beside the arrays of an entry
Arrays = Mapping[str, NDArray[Any]]
Result = TypeVar("Result")


def key_of(*parts: Any) -> str:
    """Returns the digest of values that MessagePack can hold."""
    return content_digest(msgpack.packb(parts))


def digest_of_array(values: Floats) -> str:
    """Returns the digest of an array: its type, shape and values."""
    return key_of(str(values.dtype), values.shape, np.ascontiguousarray(values).tobytes())


class CacheError(MotionError):
    """The cache cannot be written. It is no fault of a clip, so the whole job fails and the bank stays as it was."""


class Cache:
    """Entries in one folder, which the first entry creates."""

    def __init__(self, folder: Path) -> None:
        self.folder, self._folder = folder, str(folder)

    @property
    def place(self) -> str:
        """Where the entries are, for messages."""
        return str(self.folder)

    def holds(self, key: str) -> bool:
        """Returns whether an entry exists. It may still be damaged."""
        return os.path.exists(self._file(key))

    def read_ahead(self, keys: Iterable[str]) -> None:
        """Announces entries that are loaded soon, to those caches that are slow to answer. This is none."""

    def load(self, key: str, unpack: Callable[[Fields, Arrays], Result]) -> Result | None:
        """Returns what `unpack` makes of an entry. Only the arrays that `unpack` uses are read.

        Returns None if the entry is missing, damaged, or of another kind.
        """
        try:
            with self._open(key) as source:
                entry = _Entry(source)
                return unpack(entry.fields, entry)
        except Exception:  # any damaged entry can be made again
            return None

    def store(self, key: str, fields: Fields, arrays: Arrays) -> None:
        """Writes an entry, whole or not at all. Raises CacheError."""
        partial = f"{self._folder}/.{key}.entry.{uuid4().hex}"  # a thread or another machine may write an equal entry
        try:
            with self._created(partial) as sink:
                write_entry(sink, fields, arrays)
            os.replace(partial, self._file(key))
        except OSError as error:
            with suppress(OSError):
                os.unlink(partial)
            problem = f"cannot write to the cache: {error.strerror}"
            raise CacheError(problem, file=str(self.folder), mend=mend_of(error)) from None

    def keep_only(self, keys: Collection[str]) -> None:
        """Removes all other entries, and partial files of killed jobs."""
        names = {f"{key}.entry" for key in keys}
        for file in self.folder.iterdir():
            unused = OURS.fullmatch(file.name) and file.name not in names
            if unused or OUR_PARTIAL.fullmatch(file.name):
                with suppress(OSError):  # the next job removes it
                    file.unlink()

    def _open(self, key: str) -> BufferedIOBase:
        return open(self._file(key), "rb")

    def _created(self, file: str) -> BinaryIO:
        try:
            return open(file, "wb")
        except (FileNotFoundError, NotADirectoryError):
            self.folder.mkdir(parents=True, exist_ok=True)
            return open(file, "wb")

    def _file(self, key: str) -> str:  # of a Path it would take three times as long
        return f"{self._folder}/{key}.entry"


class _Entry(Mapping[str, NDArray[Any]]):
    """An entry in an open file. An array is read when it is asked for. Raises ValueError and others if damaged."""

    def __init__(self, source: BufferedIOBase) -> None:
        self._source, size = source, source.seek(0, SEEK_END)
        source.seek(0)
        magic, length, checksum = START.unpack(source.read(START.size))
        self._first, self._room = START.size + length, size - START.size - length
        if magic != MAGIC or self._room < 0:
            raise ValueError("not an entry")
        head = source.read(length)
        if zlib.crc32(head) != checksum:
            raise ValueError("the head is damaged")
        self.fields, self._arrays = msgpack.unpackb(head)

    def __getitem__(self, name: str) -> NDArray[Any]:
        place, dtype, shape, checksum = self._arrays[name]
        kind = np.dtype(dtype)
        length = math.prod(shape) * kind.itemsize
        if kind.kind not in KINDS or min(shape, default=0) < 0 or not 0 <= place <= place + length <= self._room:
            raise ValueError(f"the array {name!r} is damaged")
        data = np.empty(length, np.uint8)
        self._source.seek(self._first + place)
        if self._source.readinto(data.data) != length or zlib.crc32(data.data) != checksum:
            raise ValueError(f"the array {name!r} is damaged")
        return data.view(kind).reshape(shape)

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)


def write_entry(sink: BinaryIO, fields: Fields, arrays: Arrays) -> None:
    """Writes an entry."""
    arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    described, place = dict[str, Any](), 0  # places are counted from the end of the head
    for name, array in arrays.items():
        described[name] = (place, array.dtype.str, array.shape, zlib.crc32(array.data))
        place += array.nbytes
    head = msgpack.packb((fields, described))
    sink.write(START.pack(MAGIC, len(head), zlib.crc32(head)) + head)
    for array in arrays.values():
        sink.write(array.data)
