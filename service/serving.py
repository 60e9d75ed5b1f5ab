"""The bank that is served. It can be exchanged; connections that play the old bank keep it until they move."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

from motionsplice import __version__
from motionsplice.motion.axes import Axes
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from motionsplice.service.background import in_background
from motionsplice.service.problems import NotReadyError
from motionsplice.service.wire.encoding import warm as warm_encoding
from motionsplice.service.wire.rig import rig_fields

logger = logging.getLogger(__name__)

CACHED_SECONDS = 3.0  # seconds in which kernels are loaded that were compiled before


@dataclass(frozen=True, eq=False)
class Edition:
    """A bank with a compiled evaluator. Only the event loop uses it, except for the estimator."""

    bank: Bank
    evaluator: Evaluator
    stage: Stage

    def rig(self, axes: Axes) -> dict[str, Any]:
        """What clients need to pose a rig: the bank's digest, its joints, their parents, offsets and roles."""
        return {"bank": self.bank.digest, **rig_fields(self.bank, axes)}

    @cached_property
    def clips(self) -> dict[str, dict[str, float]]:
        """Rate and duration of each clip, by its name."""
        return {clip.name: {"rate": clip.rate, "duration": clip.duration} for clip in self.bank.clips}

    @cached_property
    def estimator(self) -> Evaluator:
        """The evaluator of expectations, for one thread at a time."""
        return Evaluator(self.bank)

    @classmethod
    def warm(cls, bank: Bank) -> Edition:
        """Compiles the kernels or loads them from the cache; the first time takes seconds."""
        evaluator = Evaluator(bank)
        evaluator.warm()
        warm_encoding()
        stage = Stage(evaluator)
        Characters.warm(stage)
        return cls(bank, evaluator, stage)


class Serving:
    """Holds the edition that is served. Until the kernels are compiled there is a bank, but no edition.

    Attributes:
        bank: The newest bank.
        listeners: Called with the new edition at each exchange, and with the first one.
    """

    def __init__(self, bank: Bank) -> None:
        self.bank = bank
        self.listeners: list[Callable[[Edition], None]] = []
        self._edition: Edition | None = None
        self._reason = "the kernels are still being compiled"

    async def warm(self) -> None:
        """Compiles the kernels in a thread. If that fails, the service stays unready and logs why.

        If cancelled, the thread is left alone: the service would end minutes late.
        """
        logger.info("starting", extra={"bank": self.bank.digest, "version": __version__})
        began, loop = time.monotonic(), asyncio.get_running_loop()
        slow = loop.call_later(CACHED_SECONDS, logger.info, "the kernels are being compiled, which may take minutes")
        try:
            edition = await in_background(partial(Edition.warm, self.bank))
        except Exception:
            self._reason = "the kernels could not be compiled; see the service's log"
            logger.exception("the kernels could not be compiled, so no poses are served")
        else:
            self.exchange(edition)
            seconds = round(time.monotonic() - began, 3)
            logger.info("ready", extra={"bank": edition.bank.digest, "seconds": seconds})
        finally:
            slow.cancel()

    @property
    def ready(self) -> bool:
        """Whether there is an edition."""
        return self._edition is not None

    @property
    def edition(self) -> Edition:
        """The newest edition. Raises NotReadyError until there is one."""
        if self._edition is None:
            raise NotReadyError(self._reason, mend="Wait until /readyz answers 204")
        return self._edition

    def exchange(self, edition: Edition) -> None:
        """Serves another edition from now on. Called on the event loop, between two frames."""
        self.bank, self._edition = edition.bank, edition
        for listener in self.listeners:
            listener(edition)
