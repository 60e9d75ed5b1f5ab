"""The work on hands: reading a hands clip, and laying it on the body of another clip. Any process can do it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain

import numpy as np

from motionsplice.motion.errors import SettingsError, did_you_mean
from motionsplice.motion.formats.reading import Reading
from motionsplice.motion.hand_joints import fingered, has_fingers
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.skeleton import Skeleton
from motionsplice.motion.storage.place import is_named
from motionsplice.precompute.hands.rows import LaidHands, lay_hands
from motionsplice.precompute.hands.settings import FILE_NAME, HandSettings, HandsOnBody, read_hand_settings
from motionsplice.precompute.job.cache import Arrays, Cache, Fields, key_of
from motionsplice.precompute.job.clip_work import Preparation, load_or_run
from motionsplice.precompute.job.entries import FoundStride, pack_reading, unpack_reading
from motionsplice.precompute.job.readings import Clips, Identified, read
from motionsplice.precompute.job.sources import Source
from motionsplice.runtime.format.rows import Layout


def all_hands(given: Sequence[HandsOnBody], sources: Sequence[Source]) -> list[HandsOnBody]:
    """Returns the given hands and those of every `hands.toml` beside a source, in order of body and hands.

    If both name the same body and hands, the settings of the file hold. Raises SettingsError for a bad file, an unknown
    clip, or a hands clip that is also a body.
    """
    files = {source.file.parent / FILE_NAME for source in sources}
    listed = list(chain.from_iterable(read_hand_settings(file) for file in sorted(files) if is_named(file)))
    found = {(one.body, one.hands): one for one in (*given, *listed)}
    names = {source.name for source in sources}
    hands = {one.hands for one in found.values()}
    for one in found.values():
        for name, what in ((one.body, "body"), (one.hands, "hands")):
            if name not in names:
                problem = f"clip {name!r} not found, the {what} of {one.label}"
                raise SettingsError(problem, mend=did_you_mean(name, names))
        if one.body in hands:
            problem = f"{one.body!r} is a hands clip, so it cannot be the body of {one.label}"
            raise SettingsError(problem, mend="Copy the clip under another name and use the copy as the body")
    return [found[key] for key in sorted(found)]


@dataclass(frozen=True)
class HandsTask:
    """Hands to lay on a body."""

    label: str
    body: Identified
    hands: Identified
    settings: HandSettings

    @property
    def size(self) -> int:
        """The bytes of both files."""
        return self.body.size + self.hands.size

    @property
    def files(self) -> str:
        """The files that errors name."""
        return f"{self.body.files} with {self.hands.files}"


def tasks_of(laying: Sequence[HandsOnBody], bodies: Clips, hands: Clips) -> dict[str, HandsTask]:
    """Returns the tasks by label, without those whose body or hands have failed."""
    return {
        one.label: HandsTask(one.label, bodies[one.body], hands[one.hands], one.settings)
        for one in laying
        if one.body in bodies and one.hands in hands
    }


@dataclass(frozen=True)
class HandsReading:
    """The reading of a hands clip. Its entry stays in the cache as long as the bank has these hands."""

    cache: Cache

    def key(self, one: Identified) -> str:
        return key_of("hands", one.reading_key)

    def run(self, one: Identified) -> None:
        """Reads the clip and stores it. Raises MotionError if it cannot be read."""
        self.cache.store(self.key(one), *pack_reading(read(one)))

    def load(self, one: Identified) -> Reading | None:
        name = one.source.name
        return self.cache.load(self.key(one), lambda fields, arrays: unpack_reading(name, fields, arrays))


def with_fingers(stride: FoundStride, readings: HandsReading, hands: Clips) -> FoundStride:
    """Returns the stride with fingers on its rig, if any rig has fingers.

    A rig without fingers gets those of the first hands clip that has them.
    """
    rig = stride.rig
    if has_fingers(rig.skeleton, rig.roles):
        return stride
    for one in hands.values():
        reading = load_or_run(readings, one)
        if has_fingers(reading.clip.skeleton, reading.roles):
            still, roles = fingered(rig.still(), rig.roles, reading.clip.skeleton, reading.roles)
            return replace(stride, rig=Rig(still.skeleton, roles, _with_joints(rig, still.skeleton)))
    return stride


def _with_joints(rig: Rig, skeleton: Skeleton) -> Floats | None:
    """Returns the standing pose of a rig with more joints on `skeleton`; each new joint's is that of its parent."""
    if rig.pose is None:
        return None
    pose = np.empty((skeleton.joint_count, 4))
    for joint, (name, parent) in enumerate(zip(skeleton.names, skeleton.parents, strict=True)):
        pose[joint] = rig.pose[rig.skeleton.index(name)] if name in rig.skeleton.names else pose[parent]
    return pose


@dataclass(frozen=True, eq=False)
class HandsLaying:
    """The laying of hands on the bodies of prepared clips."""

    bodies: Preparation
    readings: HandsReading

    @property
    def cache(self) -> Cache:
        return self.bodies.cache

    def key(self, task: HandsTask) -> str:
        settings = sorted(asdict(task.settings).items())
        return key_of("hands on a body", self.bodies.key(task.body), self.readings.key(task.hands), settings)

    def run(self, task: HandsTask) -> None:
        """Lays the hands and stores the result. Raises MotionError if they do not fit the body."""
        reading, rig = load_or_run(self.readings, task.hands), self.bodies.rig
        layout = Layout.of(rig.skeleton, rig.roles)
        laid = lay_hands(load_or_run(self.bodies, task.body), layout, rig, reading, task.settings)
        fields = {"rate": laid.rate, "mismatch": laid.mismatch, "warnings": laid.warnings}
        self.cache.store(self.key(task), fields, {"rows": laid.rows, "frames": laid.frames})

    def load(self, task: HandsTask) -> LaidHands | None:
        def unpack(fields: Fields, arrays: Arrays) -> LaidHands:
            return LaidHands(
                name=task.hands.source.name,
                body=task.body.source.name,
                rate=fields["rate"],
                settings=task.settings,
                rows=arrays["rows"],
                frames=arrays["frames"],
                mismatch=fields["mismatch"],
                warnings=tuple(fields["warnings"]),
                source=task.hands.file_digest,
            )

        return self.cache.load(self.key(task), unpack)


def recipe_of(laying: HandsLaying, tasks: Mapping[str, HandsTask]) -> list[tuple[str, str]]:
    """Returns the keys and file digests that a bank depends on because of its hands."""
    return [(laying.key(task), task.hands.file_digest) for task in tasks.values()]
