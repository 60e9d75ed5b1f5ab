"""What can be wrong with what a user hands us. Every message says where, what, and how to mend it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class MotionError(Exception):
    """Base of all errors a user can cause.

    `problem` is one sentence; `file` and `place` (a line, a joint, a table) say where; `mend` says what to do.
    """

    def __init__(self, problem: str, *, file: str = "", place: str = "", mend: str = "") -> None:
        super().__init__(problem)
        self.problem = problem
        self.file = file
        self.place = place
        self.mend = mend

    def __str__(self) -> str:
        where = ", ".join(part for part in (self.file, self.place) if part)
        message = f"{where}: {self.problem}" if where else self.problem
        return f"{message}. {self.mend}" if self.mend else f"{message}."

    def __reduce__(self) -> tuple[object, ...]:
        """Survive the trip back from a worker process."""
        return _rebuild, (type(self), self.problem, self.file, self.place, self.mend)

    def within(self, file: str) -> MotionError:
        """The same error, saying in which file, for callers that know it."""
        return type(self)(self.problem, file=self.file or file, place=self.place, mend=self.mend)


def _rebuild(kind: type[MotionError], problem: str, file: str, place: str, mend: str) -> MotionError:
    return kind(problem, file=file, place=place, mend=mend)


class FormatError(MotionError):
    """A motion file that cannot be read."""


class ClipError(MotionError):
    """Motion data that is not a motion: wrong shapes, non-finite numbers, too few frames."""


class RoleError(MotionError):
    """A rig whose joints do not show which is the hip, the knee, the shoulder ..."""


class SkeletonError(MotionError):
    """Two rigs that cannot share one bank."""


class BaselineError(MotionError):
    """A clip that cannot serve as the baseline."""


class BankError(MotionError):
    """A bank that is missing, damaged or of another version."""


class UnknownClipError(MotionError):
    """A clip name that the bank does not hold."""


class TimeRangeError(MotionError):
    """A time that lies outside a clip, or is not a number."""


class SettingsError(MotionError):
    """A setting that means nothing: an unknown key, unit, method or posture."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A sentence with the near ones among `known`, else with all of them, else with the first ten."""
    names = sorted(known)
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    if near:
        return "Did you mean " + " or ".join(repr(one) for one in near) + "?"
    shown = ", ".join(names[:10]) + (f" and {len(names) - 10} more" if len(names) > 10 else "")
    return f"There are: {shown}"
