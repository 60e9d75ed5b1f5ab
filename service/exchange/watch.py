"""Notices a new bank in place of the one that is served."""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from pathlib import Path

from motionsplice.motion.errors import MotionError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST, mark_of
from motionsplice.service.background import in_background
from motionsplice.service.exchange.leases import Leases
from motionsplice.service.metrics import Metrics
from motionsplice.service.serving import Edition, Serving

logger = logging.getLogger(__name__)

INTERVAL = 0.5  # seconds between two checks
LATER = 10  # checks, after which a bank that could not be read is tried again


async def watch(serving: Serving, metrics: Metrics, leases: Leases, interval: float = INTERVAL) -> None:
    """Serves each new bank once it is leased or copied, verified, and its kernels are compiled. Runs until cancelled.

    A damaged bank is refused, and checked again only when its manifest changes; one that cannot be read, such as when
    the process has too many files open, is tried again. The old bank stays in service.
    """
    path = serving.bank.path
    known: tuple[int, ...] | None = ()  # unknown, as the bank may have been replaced since it was opened
    while True:
        await asyncio.sleep(interval)
        mark = mark_of(path / MANIFEST)
        if mark == known or not serving.ready:
            continue
        known = mark
        try:
            edition = await in_background(partial(_open, path, serving.bank.digest, leases))
        except MotionError as error:
            metrics.exchanges.labels("refused").inc()
            logger.warning("a new bank was refused", extra={"detail": str(error), "serving": serving.bank.digest})
            if isinstance(error.__cause__, OSError):
                known = ()
                await asyncio.sleep(LATER * interval)
        except Exception:
            metrics.exchanges.labels("refused").inc()
            logger.exception("a new bank could not be opened")
        else:
            if edition is not None:
                serving.exchange(edition)
                metrics.exchanges.labels("ok").inc()
                logger.info("a new bank is served", extra={"bank": edition.bank.digest})


def _open(path: Path, served: str, leases: Leases) -> Edition | None:
    """Returns the bank on disk, or None if it is the one that is served. Raises BankError."""
    bank = Bank.open(path, verify=False)
    if bank.digest == served:
        return None
    bank = leases.hold(bank)
    bank.verify()
    return Edition.warm(bank)
