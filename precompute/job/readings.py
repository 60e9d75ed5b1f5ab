"""The clips of a job: identified by digests, read, and kept until the bank is built."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple
from zlib import crc32

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError, MotionError
from motionsplice.motion.formats.files import files_behind, read_bytes
from motionsplice.motion.formats.reading import Reading, read_as
from motionsplice.motion.storage.place import Place, among
from motionsplice.precompute.job.cache import Cache, key_of
from motionsplice.precompute.job.entries import pack_reading, unpack_reading
from motionsplice.precompute.job.method import version_of_method
from motionsplice.precompute.job.set_aside import SetAside
from motionsplice.precompute.job.sources import Source
from motionsplice.runtime.format.manifest import content_digest

ROOM = 100_000_000  # bytes of rotations that one process keeps in memory


@dataclass(frozen=True)
class Identified:
    """A source with its digests.

    size: of its file, bytes. file_digest: of its file. reading_key: digest of everything that reading the clip depends
    on. checksums: of all files that are read with it.
    """

    source: Source
    size: int
    file_digest: str
    reading_key: str
    checksums: tuple[int, ...]

    @property
    def files(self) -> str:
        """The file that errors name."""
        return str(self.source.file)


Clips = dict[str, Identified]  # by name, in order of name


class Contents(NamedTuple):
    """The size of a file in bytes, and all files that are read with it, itself first, with their digests and CRC-32."""

    size: int
    files: tuple[Place, ...]
    digests: tuple[str, ...]
    checksums: tuple[int, ...]


def contents_of(file: Place) -> Contents:
    """Reads a file and those that are read with it, without parsing them. Raises MotionError."""
    try:
        files = files_behind(file)
        contents = [read_bytes(one) for one in files]
    except MotionError as error:
        raise error.within(str(file)) from None
    return Contents(len(contents[0]), files, tuple(map(content_digest, contents)), tuple(map(crc32, contents)))


def identify(source: Source, contents: Contents) -> Identified:
    """Returns a source with its digests, given the contents of its file."""
    reading = {**source.settings.reading, "roles": sorted(source.settings.roles.items())}
    settings = (source.file.suffix.lower(), source.animation, reading)
    key = key_of(version_of_method(), contents.digests, settings)
    source = replace(source, file=among(source.file, contents.files))
    return Identified(source, contents.size, contents.digests[0], key, contents.checksums)


def read(one: Identified) -> Reading:
    """Reads a clip. Raises MotionError if it cannot be read, or if its files have changed since `identify`."""
    source, found = one.source, set[int]()

    def noted(file: Place) -> bytes:
        data = read_bytes(file)
        found.add(crc32(data))  # a fifth of a digest's time
        return data

    reading = read_as(source.settings, source.file, source.animation, noted)
    if not found <= set(one.checksums):
        raise ClipError("it changed while it was read", file=str(source.file), mend="Start again")
    return reading


class Readings:
    """Clips on their way from the search for a stride to their preparation, until the bank is built.

    They stay in memory as far as they fit into `room`, in bytes; others are set aside in a temporary file. A worker
    process has no room, and puts those that it has read into the cache, where others find them. What was found of clips
    is remembered in as much room again.
    """

    def __init__(self, cache: Cache, room: int = ROOM) -> None:
        self.cache, self._in_worker, self._room, self._room_for_results = cache, room == 0, room, room
        self._kept: dict[str, Reading] = {}
        self._aside = SetAside(cache.folder)
        self._results: dict[str, Any] = {}

    def __reduce__(self) -> tuple[type[Readings], tuple[Cache, int]]:
        return Readings, (self.cache, 0)

    def close(self) -> None:
        """Gives up the temporary file."""
        self._aside.close()

    def keep(self, one: Identified, reading: Reading) -> None:
        """Keeps a reading. Raises MotionError if a worker cannot write the cache."""
        size = reading.clip.rotations.nbytes
        if self._in_worker:
            self.cache.store(one.reading_key, *pack_reading(reading))
        elif size <= self._room:
            self._room -= size
            self._kept[one.reading_key] = reading
        else:
            self._aside.put(one.reading_key, reading)

    def remember(self, key: str, result: object, size: int) -> None:
        """Remembers a result of `size` bytes that is in the cache, if there is room."""
        if size <= self._room_for_results:
            self._room_for_results -= size
            self._results[key] = result

    def result(self, key: str) -> Any:
        """Returns a result that is remembered, or None."""
        return self._results.get(key)

    def of(self, one: Identified) -> Reading:
        """Returns a reading that was kept, or reads the clip. Raises MotionError."""
        name, key = one.source.name, one.reading_key
        kept = self._kept.get(key) or self._aside.get(key)
        if kept is not None:  # perhaps that of an equal file
            clip = kept.clip
            same = Clip.of_valid(name, clip.skeleton, clip.rate, clip.root_positions, clip.rotations)
            return replace(kept, clip=same)
        found = self.cache.load(key, lambda fields, arrays: unpack_reading(name, fields, arrays))
        return read(one) if found is None else found
