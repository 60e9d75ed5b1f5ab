"""The work on one clip. Any process can do it; the result goes into the cache, not back through a pipe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from functools import partial
from typing import Any, NamedTuple, Protocol, TypeVar
from zlib import crc32

from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import BaselineError, ClipError, MotionError
from motionsplice.motion.formats.files import files_behind, read_bytes
from motionsplice.motion.formats.reading import Reading, read_as
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.storage.place import Place, among
from motionsplice.precompute.alignment.baseline import Baseline, find_baseline
from motionsplice.precompute.job.cache import Cache, digest_of_array, key_of
from motionsplice.precompute.job.entries import (
    LARGE,
    FoundStride,
    StrideSearched,
    pack_prepared,
    pack_reading,
    pack_rig,
    pack_stride,
    unpack_prepared,
    unpack_reading,
    unpack_stride,
)
from motionsplice.precompute.job.method import version_of
from motionsplice.precompute.job.set_aside import SetAside
from motionsplice.precompute.job.sources import Source
from motionsplice.precompute.preparation.prepared import PreparedClip, prepare
from motionsplice.runtime.format.manifest import content_digest

ROOM = 100_000_000  # bytes of rotations that one process keeps in memory

Result = TypeVar("Result", covariant=True)
Task = TypeVar("Task", contravariant=True)


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


class Work(Protocol[Task, Result]):
    """Work on a clip, or on several clips together, whose result goes into the cache."""

    @property
    def cache(self) -> Cache: ...
    def key(self, one: Task, /) -> str: ...
    def run(self, one: Task, /) -> None: ...
    def load(self, one: Task, /) -> Result | None: ...


def load_or_run(work: Work[Task, Result], one: Task) -> Result:
    """Loads the result of a task, and runs the task if the cache entry is missing or damaged. Raises MotionError."""
    found = work.load(one)
    if found is None:
        work.run(one)
        found = work.load(one)
    if found is None:
        raise _unreadable(work.cache)
    return found


def _unreadable(cache: Cache) -> MotionError:
    """Returns the error for an entry that cannot be read back right after it was written."""
    mend = "Check the disk, then delete the folder and start again"
    return MotionError("the cache cannot be read back after writing", file=cache.place, mend=mend)


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
    key = key_of(version_of("motion", "runtime", "precompute"), contents.digests, settings)
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


@dataclass(frozen=True)
class StrideSearch:
    """The search for a stride in a clip."""

    readings: Readings

    @property
    def cache(self) -> Cache:
        return self.readings.cache

    def key(self, one: Identified) -> str:
        return key_of("stride", one.reading_key)

    def choice_key(self, clips: Clips) -> str:
        """Returns the key of the choice of the most typical stride among these clips."""
        return key_of("most typical", [(name, self.key(one)) for name, one in clips.items()])

    def run(self, one: Identified) -> None:
        """Stores the clip's stride, or that it has none. Raises MotionError if the clip cannot be read.

        The reading is kept too, until the bank is built: `Preparation` needs it again.
        """
        reading = read(one)
        self.readings.keep(one, reading)
        try:
            ring = find_baseline(reading.clip, reading.roles)
        except BaselineError:
            ring = None
        key, searched = self.key(one), StrideSearched(Rig.of(reading.clip, reading.roles), ring)
        fields, arrays = pack_stride(searched)
        self.cache.store(key, fields, arrays)
        self.readings.remember(key, searched, sum(array.nbytes for array in arrays.values()))

    def load(self, one: Identified) -> StrideSearched | None:
        name, key = one.source.name, self.key(one)
        found: StrideSearched | None = self.readings.result(key)
        if found is None:
            return self.cache.load(key, lambda fields, arrays: unpack_stride(name, fields, arrays))
        return found if found.ring is None else replace(found, ring=replace(found.ring, name=name))


@dataclass(frozen=True, eq=False)
class Preparation:
    """The preparation of a clip for a bank with this rig and baseline. Other rigs are retargeted or refused."""

    readings: Readings
    rig: Rig
    ring: Baseline
    retargeting: bool
    digest: str  # of all three

    @property
    def cache(self) -> Cache:
        return self.readings.cache

    @classmethod
    def of(cls, readings: Readings, stride: FoundStride, retargeting: bool) -> Preparation:
        rig, ring = stride.rig, stride.ring
        digest = key_of(
            pack_rig(rig), ring.leg, ring.zero, digest_of_array(ring.clouds), digest_of_array(ring.support), retargeting
        )
        return cls(readings, rig, ring, retargeting, digest)

    def key(self, one: Identified) -> str:
        cut = one.source.cut
        return key_of("prepared", one.reading_key, self.digest, None if cut is None else astuple(cut))

    def recipe(self, clips: Clips, hands: Sequence[tuple[str, str]]) -> str:
        """Returns the digest of everything that a bank of these clips, and of hands on them, depends on."""
        ring, entries = self.ring, []
        for name, one in clips.items():
            settings = one.source.settings
            labels = (settings.kind, settings.neutral, settings.mask, settings.tags)
            entries.append((name, self.key(one), labels, one.file_digest))
        return key_of("bank", ring.name, ring.start, ring.end, ring.loop, entries, hands)

    def run(self, one: Identified) -> None:
        """Prepares the clip and stores it. Raises MotionError if it cannot be read or does not fit the bank."""
        reading, cut = self.readings.of(one), one.source.cut
        clip = reading.clip if cut is None else reading.clip.frames(cut.begin, cut.end)
        made = prepare(clip, reading.roles, self.rig, self.ring, retargeting=self.retargeting, cut=cut)
        made = replace(made, notes=(*reading.notes, *made.notes), file_warnings=reading.warnings)
        if cut is not None:  # the whole clip says all of these
            made = replace(made, notes=(), file_warnings=())
        key = self.key(one)
        fields, arrays = pack_prepared(made)
        self.cache.store(key, fields, arrays)
        small = sum(array.nbytes for name, array in arrays.items() if name not in LARGE)
        self.readings.remember(key, replace(made, fetch=partial(self._fetch, one)), small)

    def load(self, one: Identified) -> PreparedClip | None:
        name, settings, key = one.source.name, one.source.settings, self.key(one)
        fetch = partial(self._fetch, one)
        found: PreparedClip | None = self.readings.result(key)
        if found is None:
            found = self.cache.load(key, lambda fields, arrays: unpack_prepared(name, fetch, fields, arrays))
        if found is None:
            return None
        return replace(
            found,
            name=name,
            fetch=fetch,
            kind=settings.kind,
            neutral=settings.neutral or "",
            mask=settings.mask,
            tags=settings.tags,
            source=one.file_digest,
            cut=one.source.cut,
        )

    def _fetch(self, one: Identified, name: str) -> NDArray[Any]:
        """Returns a large array of a result, made again if the entry is damaged. Raises MotionError."""
        for _ in range(2):
            found = self.cache.load(self.key(one), lambda _, arrays: arrays[name])
            if found is not None:
                return found
            self.run(one)
        raise _unreadable(self.cache)
