"""The work on one clip, which any process can do: what it makes goes into the cache, not back through a pipe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol, TypeVar

from numpy.typing import NDArray

from motionsplice.motion.errors import BaselineError, ClipError, MotionError
from motionsplice.motion.formats.files import Reading, files_behind, read_bytes, read_clip
from motionsplice.precompute.alignment.baseline import Baseline, find_baseline
from motionsplice.precompute.body.rig import Rig
from motionsplice.precompute.job.cache import Cache, digest_of_array, key_of
from motionsplice.precompute.job.entries import (
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
from motionsplice.precompute.job.sources import Source
from motionsplice.precompute.preparation.prepared import PreparedClip, prepare
from motionsplice.runtime.format.manifest import content_digest

Kept = TypeVar("Kept", covariant=True)
Task = TypeVar("Task", contravariant=True)


@dataclass(frozen=True)
class Identified:
    """A source, the bytes that it takes, the digest of its file, and that of all that its reading depends on."""

    source: Source
    size: int
    file_digest: str
    reading_key: str


Clips = dict[str, Identified]  # by name, in order of name


class Work(Protocol[Task, Kept]):
    """Work on a clip, or on clips that go together, whose result goes into the cache."""

    @property
    def cache(self) -> Cache: ...
    def key(self, one: Task, /) -> str: ...
    def run(self, one: Task, /) -> None: ...
    def load(self, one: Task, /) -> Kept | None: ...


def kept(work: Work[Task, Kept], one: Task) -> Kept:
    """The result of work that was done, and is done again if the entry is damaged. Raises MotionError."""
    found = work.load(one)
    if found is None:
        work.run(one)
        found = work.load(one)
    if found is None:
        raise MotionError("results do not stay as they were written", file=str(work.cache.folder))
    return found


def identify(source: Source) -> Identified:
    """Reads a clip's files, but only to digest them. Raises MotionError if they are not there."""
    try:
        contents = [read_bytes(file) for file in files_behind(source.file)]
    except MotionError as error:
        raise error.within(str(source.file)) from None
    said = (source.settings.skip_frames, source.settings.unit, sorted(source.roles.items()))
    digests = [content_digest(data) for data in contents]
    key = key_of(version_of("motion", "precompute"), source.file.suffix.lower(), digests, said)
    return Identified(source, len(contents[0]), digests[0], key)


def read(one: Identified) -> Reading:
    """Reads a clip. Raises MotionError if it cannot be, or is no longer what was identified."""
    settings = one.source.settings
    reading = read_clip(one.source.file, skip_frames=settings.skip_frames, unit=settings.unit, roles=one.source.roles)
    if identify(one.source).reading_key != one.reading_key:
        raise ClipError("it was changed while it was read", file=str(one.source.file), mend="Start again")
    return reading


@dataclass(frozen=True)
class StrideSearch:
    """The search for a stride in a clip."""

    cache: Cache

    def key(self, one: Identified) -> str:
        return key_of("stride", one.reading_key)

    def choice_key(self, clips: Clips) -> str:
        """The key of which stride is the most typical of these clips'."""
        return key_of("most typical", [(name, self.key(one)) for name, one in clips.items()])

    def run(self, one: Identified) -> None:
        """Raises MotionError if the clip cannot be read; that it has no stride is a result like others.

        What was read is kept until the bank is built, for it is needed once more.
        """
        reading = read(one)
        self.cache.store(one.reading_key, *pack_reading(reading))
        try:
            ring = find_baseline(reading.clip, reading.roles)
        except BaselineError:
            ring = None
        self.cache.store(self.key(one), *pack_stride(StrideSearched(Rig(reading.clip.skeleton, reading.roles), ring)))

    def load(self, one: Identified) -> StrideSearched | None:
        name = one.source.name
        return self.cache.load(self.key(one), lambda said, arrays: unpack_stride(name, said, arrays))


@dataclass(frozen=True, eq=False)
class Preparation:
    """The preparation of a clip for a bank with this rig and baseline."""

    cache: Cache
    rig: Rig
    ring: Baseline
    rig_and_ring: str  # their digest

    @classmethod
    def of(cls, cache: Cache, stride: FoundStride) -> Preparation:
        rig, ring = stride.rig, stride.ring
        return cls(cache, rig, ring, key_of(pack_rig(rig), ring.leg, ring.zero, digest_of_array(ring.clouds)))

    def key(self, one: Identified) -> str:
        return key_of("prepared", one.reading_key, self.rig_and_ring)

    def recipe(self, clips: Clips, hands: Sequence[tuple[str, str]]) -> str:
        """The digest of all that a bank of these clips, and of hands on them, depends on."""
        ring, said = self.ring, []
        for name, one in clips.items():
            settings = one.source.settings
            said.append((name, self.key(one), settings.kind, settings.neutral, settings.tags, one.file_digest))
        return key_of("bank", version_of("runtime"), ring.name, ring.start, ring.end, ring.loop, said, hands)

    def run(self, one: Identified) -> None:
        """Raises MotionError if the clip cannot be read or does not fit the bank."""
        name = one.source.name
        reading = self.cache.load(one.reading_key, lambda said, arrays: unpack_reading(name, said, arrays))
        if reading is None:
            reading = read(one)
        made = prepare(reading.clip, reading.roles, self.rig.skeleton, self.rig.roles, self.ring)
        made = replace(made, notes=reading.notes, file_warnings=reading.warnings)
        self.cache.store(self.key(one), *pack_prepared(made))

    def load(self, one: Identified) -> PreparedClip | None:
        name, settings = one.source.name, one.source.settings
        fetch = partial(self._fetch, one)
        found = self.cache.load(self.key(one), lambda said, arrays: unpack_prepared(name, fetch, said, arrays))
        if found is None:
            return None
        neutral = settings.neutral or ""
        return replace(found, kind=settings.kind, neutral=neutral, tags=settings.tags, source=one.file_digest)

    def _fetch(self, one: Identified, name: str) -> NDArray[Any]:
        """What is large of a result, made again if the entry is damaged. Raises MotionError."""
        for _ in range(2):
            found = self.cache.load(self.key(one), lambda _, arrays: arrays[name])
            if found is not None:
                return found
            self.run(one)
        raise MotionError("results do not stay as they were written", file=str(self.cache.folder))
