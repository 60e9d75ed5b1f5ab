"""A local copy of a bank at a URL, for the service to map, and the process that keeps it up to date."""

from __future__ import annotations

import logging.config
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path

from motionsplice.motion.errors import MotionError
from motionsplice.motion.storage.remote import Remote
from motionsplice.precompute.job.install import install_bank
from motionsplice.precompute.job.processes import end_with_parent
from motionsplice.runtime.format.manifest import MANIFEST
from motionsplice.service.logs import log_config

INTERVAL = 5.0  # seconds between two looks at the manifest

logger = logging.getLogger(__name__)


@contextmanager
def copied(bank: Remote, folder: Path, *, follow: bool, interval: float = INTERVAL) -> Iterator[None]:
    """Copies a bank to a folder, and if `follow` each new one that takes its place while the context lasts.

    A process of its own follows: the parsing, the network and their libraries do not delay frames. Raises MotionError
    if the first copy fails.
    """
    mark = (bank / MANIFEST).mark()
    install_bank(bank, folder)
    if not follow:
        yield
        return
    follower = get_context("spawn").Process(target=_follow, args=(bank, folder, mark, interval), daemon=True)
    follower.start()
    try:
        yield
    finally:
        follower.terminate()
        follower.join()


def _follow(bank: Remote, folder: Path, known: str | None, interval: float) -> None:
    """Copies each new bank, until the parent ends. What fails is logged once, and tried again."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's
    end_with_parent()
    logging.config.dictConfig(log_config())
    logged = ""
    while True:
        time.sleep(interval)
        try:
            mark = (bank / MANIFEST).mark()
            if mark not in (known, None):
                digest = install_bank(bank, folder)
                known, logged = mark, ""
                logger.info("a new bank was copied", extra={"bank": digest, "from": str(bank)})
        except MotionError as error:
            if str(error) != logged:
                logged = str(error)
                logger.warning("a new bank could not be copied", extra={"detail": logged})
