"""A file or folder at a URL that fsspec knows (`s3://`, `gs://`, `memory://`), as far as `Path` is used of it."""

from __future__ import annotations

import posixpath
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from motionsplice.motion.errors import MotionError

EXTRAS = {"s3": "s3", "s3a": "s3", "gs": "gs", "gcs": "gs"}  # extras of motionsplice by protocol
IN_ONE = {name: {"max_concurrency": 1} for name in ("s3", "s3a")}  # else s3fs asks for a file's size before it reads it


class StorageError(MotionError):
    """A URL cannot be used: its protocol is not installed, or the storage does not answer or does not allow it.

    It is no fault of a clip, so the whole job fails and the bank stays as it was.
    """


class Listed(NamedTuple):
    """An entry of a listing: a file or a folder."""

    is_dir: bool
    size: int


Listings = dict[str, dict[str, Listed]]  # by URL of the folder, then by name


@dataclass(frozen=True, order=True)
class Remote:
    """A file or folder at a URL. It and those found from it list each folder once, and then know what was there.

    Missing files raise FileNotFoundError, all else that can go wrong StorageError.
    """

    url: str  # without a slash at the end
    listings: Listings = field(default_factory=dict, compare=False, repr=False)
    carries: bool = field(default=False, compare=False, repr=False)  # its listings into other processes

    def __str__(self) -> str:
        return self.url

    def __reduce__(self) -> tuple[type[Remote], tuple[str, Listings, bool]]:
        return Remote, (self.url, self.listings if self.carries else {}, self.carries)  # others list anew

    def among(self, files: Collection[Remote]) -> Remote:
        """Returns the same file, which knows of these files in its folder, and of no others, in any process."""
        names = {file.name for file in files if file.parent == self.parent}
        beside = {name: found for name, found in self.parent.listed().items() if name in names}
        return Remote(self.url, {self.parent.url: beside}, carries=True)

    @property
    def name(self) -> str:
        return self.url.rpartition("/")[2]

    @property
    def stem(self) -> str:
        return PurePosixPath(self.name).stem

    @property
    def suffix(self) -> str:
        return PurePosixPath(self.name).suffix

    @property
    def parent(self) -> Remote:
        return Remote(self.url.rpartition("/")[0], self.listings)

    def __truediv__(self, name: str) -> Remote:
        return Remote(f"{self.url}/{name}", self.listings)

    def resolve(self) -> Remote:
        """Returns the same place without `..` in its URL."""
        protocol, _, path = self.url.partition("://")
        return Remote(f"{protocol}://{posixpath.normpath(path)}", self.listings)

    def is_relative_to(self, other: Remote) -> bool:
        return self.url == other.url or self.url.startswith(f"{other.url}/")

    def exists(self) -> bool:
        beside = self._beside
        return self.is_dir() or self.is_file() if beside is None else self.name in beside

    def is_dir(self) -> bool:
        beside = self._beside
        return bool(self.listed()) if beside is None else self.name in beside and beside[self.name].is_dir

    def is_file(self) -> bool:
        found = self.parent.listed().get(self.name)
        return found is not None and not found.is_dir

    @property
    def _beside(self) -> dict[str, Listed] | None:
        """The listing of the parent folder, None if it has not been listed."""
        return self.listings.get(self.parent.url)

    def iterdir(self) -> Iterator[Remote]:
        return (self / name for name in self.listed())

    def listed(self) -> dict[str, Listed]:
        """Returns what the folder holds, by name; empty if it is none. A second call returns the same."""
        if self.url not in self.listings:
            self.listings[self.url] = self._list()
        return self.listings[self.url]

    def read_bytes(self) -> bytes:
        """Returns the contents of the file, by one request."""
        with _reached(self.url, **IN_ONE.get(self.url.partition("://")[0], {})) as (system, path):
            return bytes(system.cat_file(path))

    def read_text(self, encoding: str) -> str:
        return self.read_bytes().decode(encoding)

    def write_bytes(self, data: bytes) -> None:
        """Writes the file, on object stores whole or not at all."""
        with _reached(self.url) as (system, path):
            system.pipe_file(path, data)

    def download(self, file: Path) -> None:
        """Copies the file to this machine."""
        with _reached(self.url) as (system, path):
            system.get_file(path, str(file))

    def upload(self, file: Path) -> None:
        """Copies a file of this machine here, on object stores whole or not at all."""
        with _reached(self.url) as (system, path):
            system.put_file(str(file), path)

    def remove(self, names: Collection[str]) -> None:
        """Removes files of this folder."""
        with _reached(self.url) as (system, path):
            if names:
                system.rm([f"{path}/{name}" for name in sorted(names)])

    def mark(self) -> str | None:
        """Returns what changes when the file is written anew, as far as the storage says so; None if it is missing."""
        try:
            with _reached(self.url) as (system, path):
                system.invalidate_cache()
                info = system.info(path)
        except FileNotFoundError:
            return None
        keys = ("ETag", "etag", "md5Hash", "LastModified", "mtime", "updated", "created", "size")
        return repr([info.get(key) for key in keys])

    def _list(self) -> dict[str, Listed]:
        try:
            with _reached(self.url) as (system, path):
                system.invalidate_cache()  # of earlier jobs in this process
                found = system.ls(path, detail=True)
        except (FileNotFoundError, NotADirectoryError):
            return {}
        names = {one["name"].strip("/"): Listed(one["type"] == "directory", one["size"] or 0) for one in found}
        names.pop(path.strip("/"), None)  # the folder itself, or a file
        return {name.rpartition("/")[2]: one for name, one in sorted(names.items())}


@contextmanager
def _reached(url: str, **options: Any) -> Iterator[tuple[Any, str]]:
    """Yields the file system of a URL and the path in it. What it raises becomes a StorageError that names the URL.

    options: those of the file system.
    """
    protocol = url.partition("://")[0]
    try:
        from fsspec.core import url_to_fs

        yield url_to_fs(url, **options)
    except (FileNotFoundError, NotADirectoryError, MotionError):
        raise
    except (ImportError, ValueError) as error:
        extra = EXTRAS.get(protocol)
        mend = f"Run `pip install 'motionsplice[{extra}]'`" if extra else "Install what fsspec needs for it"
        raise StorageError(f"{protocol}:// cannot be used: {error}", file=url, mend=mend) from None
    except Exception as error:
        problem = f"the storage cannot be used: {type(error).__name__}: {error}"
        raise StorageError(problem, file=url, mend="Check the URL, the credentials and the network") from None
