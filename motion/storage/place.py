"""A file or folder, on this machine or at a URL."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, Self, TypeVar
from urllib.parse import unquote, urlsplit

from motionsplice.motion.errors import SettingsError
from motionsplice.motion.storage.remote import Remote

URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")  # two letters or more: C: is a disk
READERS = 32  # files at a URL that are read at the same time

Item = TypeVar("Item")
Result = TypeVar("Result")
At = TypeVar("At", bound="Place")


class Place(Protocol):
    """The methods of a file or folder that reading calls. `Path` and `Remote` have them."""

    @property
    def name(self) -> str: ...
    @property
    def stem(self) -> str: ...
    @property
    def suffix(self) -> str: ...
    @property
    def parent(self) -> Self: ...
    def __truediv__(self, name: str, /) -> Self: ...
    def __lt__(self, other: Any, /) -> bool: ...
    def __hash__(self) -> int: ...
    def exists(self) -> bool: ...
    def is_dir(self) -> bool: ...
    def is_file(self) -> bool: ...
    def iterdir(self) -> Iterator[Self]: ...
    def read_bytes(self) -> bytes: ...
    def read_text(self, encoding: str) -> str: ...
    def resolve(self) -> Self: ...
    def is_relative_to(self, other: Self, /) -> bool: ...


def place_of(path: str | os.PathLike[str] | Place) -> Path | Remote:
    """Returns where a path or URL leads: `s3://bucket/clips` to a Remote, `file:///srv/clips` to a Path.

    Raises SettingsError if it is empty, as from a variable that is not set: Python takes that for the current folder.
    """
    if isinstance(path, Path | Remote):
        return path
    text = os.fspath(path)  # type: ignore[arg-type]  # the others have been returned
    if not text:
        raise SettingsError("the path is empty", mend="Name a file or folder; . is the current folder")
    if not URL.match(text):
        return Path(text)
    return Path(unquote(urlsplit(text).path)) if text.lower().startswith("file:") else Remote(text.rstrip("/"))


def exists(place: Place) -> bool:
    """As the method, but that of Path raises for some odd folders, as do the methods of the functions below."""
    return os.path.exists(place) if isinstance(place, Path) else place.exists()


def is_dir(place: Place) -> bool:
    return os.path.isdir(place) if isinstance(place, Path) else place.is_dir()


def is_named(place: Place) -> bool:
    """Whether a folder has this name, if only as a link that leads nowhere."""
    return os.path.lexists(place) if isinstance(place, Path) else place.exists()


def may_never_end(place: Place) -> bool:
    """Whether it is a pipe or a device."""
    return isinstance(place, Path) and exists(place) and not (os.path.isfile(place) or os.path.isdir(place))


def resolved(place: At) -> At:
    return type(place)(os.path.realpath(place)) if isinstance(place, Path) else place.resolve()


def among(place: Place, files: Collection[Place]) -> Place:
    """Returns a file that another process can read with these other files, without a look at what is in its folder."""
    if isinstance(place, Remote):
        return place.among([file for file in files if isinstance(file, Remote)])
    return place


def read_ahead(read: Callable[[Item], Result], items: Iterable[Item], place: Callable[[Item], Place]) -> list[Result]:
    """Returns what `read` makes of each item. Those at URLs are read READERS at a time, so that their waits overlap."""
    waiting, results = iter(items), list[Result]()
    while some := list(islice(waiting, 8 * READERS)):
        if any(isinstance(place(one), Remote) for one in some):
            with ThreadPoolExecutor(READERS) as pool:
                results += pool.map(read, some)
        else:
            results += map(read, some)
    return results
