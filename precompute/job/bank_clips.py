"""The clips of a bank on their way into it, of which only one is in memory at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from motionsplice.precompute.job.clip_work import Preparation, load_or_run
from motionsplice.precompute.job.hybrids import Hybrids
from motionsplice.precompute.job.neutrals import Label
from motionsplice.precompute.job.readings import Clips
from motionsplice.precompute.preparation.prepared import PreparedClip


@dataclass(frozen=True, eq=False)
class BankClips(Mapping[str, PreparedClip]):
    """Prepared clips by name, each loaded from the cache whenever it is asked for. Asking may raise MotionError."""

    preparation: Preparation
    aligned: Clips
    hybrids: Hybrids
    labels: Mapping[str, Label] = field(default_factory=dict)

    def __getitem__(self, name: str) -> PreparedClip:
        one = load_or_run(self.preparation, self.aligned[name])
        one = replace(one, stretches=tuple(self.hybrids.get(name, ())))
        return self.labels[name].on(one) if self.labels else one

    def __iter__(self) -> Iterator[str]:
        return iter(self.aligned)

    def __len__(self) -> int:
        return len(self.aligned)
