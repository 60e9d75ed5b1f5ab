"""The errors that a user's input can cause. Every message says where, what is wrong, and what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from unicodedata import normalize

LONGEST_NAME = 200  # characters of a name that others are compared with; it takes seconds for one of a megabyte


class MotionError(Exception):
    """Base class of all errors that a user's input can cause.

    Printed as "file, place: problem. mend", without the parts that are empty. All parts are attributes too.

    Args:
        problem: What is wrong, in one sentence without a full stop.
        file: The file that is affected.
        place: Where in the file or the data: a line, a frame, a joint, a table.
        mend: What to do about it, as an imperative.
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
        """Keeps all fields when the error is pickled, as it is on the way back from a worker process."""
        return _rebuild, (type(self), self.problem, self.file, self.place, self.mend)

    def within(self, file: str) -> MotionError:
        """Returns the same error with `file` filled in, unless it names a file already."""
        return self.of_file(self.file or file)

    def of_file(self, file: str) -> MotionError:
        """Returns the same error with another file."""
        return type(self)(self.problem, file=file, place=self.place, mend=self.mend)


def _rebuild(kind: type[MotionError], problem: str, file: str, place: str, mend: str) -> MotionError:
    return kind(problem, file=file, place=place, mend=mend)


class FormatError(MotionError):
    """A motion file cannot be read: it is missing, malformed, cut short or of an unsupported type."""


class ClipError(MotionError):
    """Motion data is invalid or unsuitable: wrong shapes, non-finite numbers, too few frames."""


class RoleError(MotionError):
    """The roles of a rig's joints (hip, knee, shoulder ...) cannot be found, or do not fit its motion."""


class SkeletonError(MotionError):
    """Two rigs do not match: they cannot share a bank, or one's hands cannot be laid on the other."""


class BaselineError(MotionError):
    """A clip cannot serve as the baseline."""


class BankError(MotionError):
    """A bank is missing, damaged or of another version."""


class UnknownClipError(MotionError):
    """The bank has no clip of that name."""


class TimeRangeError(MotionError):
    """A time is outside its clip, or is not a number."""


class SettingsError(MotionError):
    """A setting is invalid: an unknown key, unit, method or posture, or a value out of range."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Returns a hint for an unknown `name`: up to three similar names of `known`, or else the first ten of them."""
    names = sorted(known)
    short = len(name) <= LONGEST_NAME
    if short and (alike := [one for one in names if one != name and _composed(one) == _composed(name)]):
        return f"Did you mean {alike[0]!a}? It looks the same, but has other Unicode characters"
    if near := difflib.get_close_matches(name, names, n=3, cutoff=0.5) if short else []:
        return "Did you mean " + " or ".join(repr(match) for match in near) + "?"
    listed = ", ".join(names[:10]) + (f" and {len(names) - 10} more" if len(names) > 10 else "")
    return f"Choose one of {listed}" if listed else "None are available"


def _composed(name: str) -> str:
    """Returns a name with each accent in its letter's own character: macOS writes them apart."""
    return normalize("NFC", name)


def listed(names: list[str]) -> str:
    """Returns the first five names as text."""
    return f"{', '.join(names[:5])}{' ...' * (len(names) > 5)}"
