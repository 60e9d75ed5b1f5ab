"""The reports of a run of the offline job: its progress, and at the end its outcome."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from motionsplice.motion.errors import MotionError
from motionsplice.precompute.alignment.baseline import Baseline

Progress = Callable[[str, int, int], None]  # the stage, how many of its clips are done, and how many there are


@dataclass(frozen=True)
class Outcome:
    """The result of a run of the offline job.

    Attributes:
        digest: The bank's digest.
        baseline: The stride that all clips are aligned to.
        clips: Names of the bank's clips.
        failed: The errors of clips that were left out, by name.
        reused: How many clips an earlier run had already aligned.
        unchanged: Whether this very bank was already there.
    """

    digest: str
    baseline: Baseline = field(repr=False)
    clips: tuple[str, ...]
    failed: Mapping[str, MotionError]
    reused: int
    unchanged: bool
