"""Noticing a new bank in the place of the one that is served."""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from pathlib import Path

from motionsplice.motion.errors import BankError, MotionError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST, mark_of
from motionsplice.service.exchange.background import in_background
from motionsplice.service.metrics import Metrics
from motionsplice.service.serving import Edition, Serving

logger = logging.getLogger(__name__)

INTERVAL = 0.5  # seconds between two looks


async def watch(serving: Serving, metrics: Metrics, interval: float = INTERVAL) -> None:
    """Serves each new bank that is written, once it is verified and its kernels are warm.

    One that is damaged is refused, and not looked at again until its manifest changes: the bank that is served goes on.
    """
    path = serving.bank.path
    seen: tuple[int, ...] | None = ()  # for the bank may have been written over since it was opened
    while True:
        await asyncio.sleep(interval)
        mark = mark_of(path / MANIFEST)
        if mark == seen or not serving.ready:
            continue
        seen = mark
        try:
            edition = await in_background(partial(_open, path, serving.bank.digest))
        except MotionError as error:
            metrics.exchanges.labels("refused").inc()
            logger.warning("a new bank was refused", extra={"detail": str(error), "serving": serving.bank.digest})
        except Exception:
            metrics.exchanges.labels("refused").inc()
            logger.exception("a new bank could not be opened")
        else:
            if edition is not None:
                serving.exchange(edition)
                metrics.exchanges.labels("ok").inc()
                logger.info("a new bank is served", extra={"bank": edition.bank.digest})


def _open(path: Path, served: str) -> Edition | None:
    """The bank that is there now, unless it is the one that is served. Raises BankError."""
    try:
        bank = Bank.open(path, verify=False)
        if bank.digest == served:
            return None
        bank.verify()
    except OSError as error:
        raise BankError(f"it cannot be read: {error.strerror}", file=str(error.filename or path)) from None
    return Edition.warm(bank)
