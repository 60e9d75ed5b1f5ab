"""A bank's skeleton other than the baseline's: that of a file, or that of another bank."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from motionsplice.motion.errors import BaselineError, SkeletonError
from motionsplice.motion.formats.reading import read_rig
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.storage.remote import Remote
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.job.cache import Cache, key_of
from motionsplice.precompute.job.entries import FoundStride, StrideSearched, pack_rig, pack_stride, unpack_stride
from motionsplice.precompute.job.readings import Identified, Readings
from motionsplice.runtime.bank import Bank


def rig_of(path: Path | Remote, roles: Mapping[str, str | Sequence[str]]) -> Rig:
    """Returns the rig of a motion file, of a character without a motion, or of the bank in a folder.

    Raises MotionError.
    """
    if path.is_dir():
        if isinstance(path, Remote):
            mend = "Copy it with `motionsplice install`, and name the copy"
            raise SkeletonError("the skeleton of a bank at a URL cannot be read", file=str(path), mend=mend)
        bank = Bank.open(path)
        return Rig.of(bank.motion(bank.baseline.clip), bank.roles)
    reading = read_rig(path, roles)
    return Rig.of(reading.clip, reading.roles)


@dataclass(frozen=True, eq=False)
class StrideOnSkeleton:
    """The search for the baseline's stride after its clip was moved onto a rig."""

    readings: Readings
    rig: Rig
    retargeting: bool

    @property
    def cache(self) -> Cache:
        return self.readings.cache

    def key(self, one: Identified) -> str:
        return key_of("stride on a skeleton", one.reading_key, pack_rig(self.rig), self.retargeting)

    def run(self, one: Identified) -> None:
        """Stores the stride. Raises MotionError."""
        reading, rig = self.readings.of(one), self.rig
        try:
            fitted = onto_rig(reading.clip, reading.roles, rig, retargeting=self.retargeting).clip
        except SkeletonError as error:
            raise BaselineError(f"the baseline does not fit the skeleton: {error}") from None
        found = StrideSearched(Rig.of(fitted, rig.roles), find_baseline(fitted, rig.roles))
        self.cache.store(self.key(one), *pack_stride(found))

    def load(self, one: Identified) -> FoundStride | None:
        name = one.source.name
        found = self.cache.load(self.key(one), lambda fields, arrays: unpack_stride(name, fields, arrays))
        return None if found is None else found.found()
