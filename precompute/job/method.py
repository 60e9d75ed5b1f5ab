"""The version of the method, by which results of another one are not taken for its own."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version
from importlib.resources import files
from importlib.resources.abc import Traversable

from motionsplice.precompute.job.cache import key_of

LIBRARIES = ("numba", "numpy", "scipy")


@cache
def version_of(*packages: str) -> str:
    """The digest of all sources of our packages, and of the versions of the libraries that they call.

    A number to be raised by hand would be forgotten once, and a stale result is in no way to be seen. So any change of
    a source, even of a comment, costs a rebuild, and none can be forgotten.
    """
    sources = [source for package in packages for source in _sources(files(f"motionsplice.{package}"))]
    return key_of(sources, [(name, version(name)) for name in LIBRARIES])


def _sources(folder: Traversable) -> list[tuple[str, bytes]]:
    found = []
    for entry in sorted(folder.iterdir(), key=lambda one: one.name):
        if entry.is_dir() and entry.name != "__pycache__":
            found += _sources(entry)
        elif entry.name.endswith(".py"):
            found.append((entry.name, entry.read_bytes()))
    return found
