"""Where the offline job writes its bank and its cache: a folder, or a URL."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from motionsplice.motion.errors import BankError
from motionsplice.motion.storage.remote import Remote
from motionsplice.precompute.job.alone import alone_in
from motionsplice.precompute.job.cache import Cache
from motionsplice.precompute.job.install import publish_bank, published
from motionsplice.precompute.job.outcome import Progress
from motionsplice.precompute.job.remote_cache import RemoteCache
from motionsplice.runtime.bank import Bank

CACHE = "cache"  # a folder in the bank's


@dataclass(frozen=True)
class Destination:
    """A place that one job has for itself.

    holds: whether the bank of this digest is there, complete. write: calls a function that writes a bank to a folder,
    puts that bank in place and returns its digest.
    """

    cache: Cache
    holds: Callable[[str], bool]
    write: Callable[[Callable[[Path], str]], str]


@contextmanager
def destination(out: Path | Remote, progress: Progress) -> Iterator[Destination]:
    """Prepares a place to write to. A folder is locked; at a URL nothing keeps two jobs apart."""
    if isinstance(out, Path):
        with alone_in(out, progress):
            yield Destination(Cache(out / CACHE), lambda digest: _holds_bank(out, digest), lambda write: write(out))
        return
    with TemporaryDirectory(prefix="motionsplice-") as name:
        folder = Path(name)

        def write_and_publish(write: Callable[[Path], str]) -> str:
            digest = write(folder / "bank")
            publish_bank(folder / "bank", out, progress)
            return digest

        cache = RemoteCache(out / CACHE, folder / CACHE)
        yield Destination(cache, lambda digest: published(out, digest), write_and_publish)


def _holds_bank(path: Path, digest: str) -> bool:
    """Whether the folder holds the bank of this digest, complete and undamaged."""
    try:
        return Bank.open(path).digest == digest
    except BankError:
        return False
