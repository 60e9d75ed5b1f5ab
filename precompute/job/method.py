"""The version of the method. It is part of every cache key, so results of another version are not reused."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version
from importlib.resources import files
from importlib.resources.abc import Traversable

from motionsplice.precompute.job.cache import key_of

PACKAGES, LIBRARIES = ("motion", "runtime", "precompute"), ("numba", "numpy", "scipy")


@cache
def version_of_method() -> str:
    """Returns the digest of all sources of the PACKAGES that the job runs, and of the versions of their LIBRARIES.

    A version number maintained by hand would be forgotten some day, and a stale result looks like any other. So every
    change of a source, even of a comment, causes a rebuild.
    """
    sources = [source for package in PACKAGES for source in _sources(files(f"motionsplice.{package}"), package)]
    return key_of(sources, [(name, version(name)) for name in LIBRARIES])


def _sources(folder: Traversable, path: str) -> list[tuple[str, bytes]]:
    found = []
    for entry in sorted(folder.iterdir(), key=lambda one: one.name):
        if entry.is_dir() and entry.name != "__pycache__":
            found += _sources(entry, f"{path}/{entry.name}")
        elif entry.name.endswith(".py"):
            found.append((f"{path}/{entry.name}", entry.read_bytes()))
    return found
