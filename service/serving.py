"""The bank that is served. It may be exchanged for another; what plays on the old one goes on until it moves over."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from motionsplice.service.problems import NotReadyError
from motionsplice.service.wire.encoding import warm as warm_encoding

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Edition:
    """A bank with a warm evaluator, which the event loop alone uses."""

    bank: Bank
    evaluator: Evaluator
    stage: Stage

    @property
    def rig(self) -> dict[str, Any]:
        """What clients must know to take its frames apart: the bank's digest, its joints and their parents."""
        skeleton = self.bank.skeleton
        return {"bank": self.bank.digest, "joints": list(skeleton.names), "parents": skeleton.parents.tolist()}

    @classmethod
    def warm(cls, bank: Bank) -> Edition:
        """Compiles the kernels, or loads them: seconds the first time."""
        evaluator = Evaluator(bank)
        evaluator.warm()
        warm_encoding()
        stage = Stage(evaluator)
        Characters.warm(stage)
        return cls(bank, evaluator, stage)


class Serving:
    """Which edition is served. Until its kernels are warm there is a bank, and no edition.

    `bank` is the newest. Whoever must know of an exchange adds itself to `listeners`.
    """

    def __init__(self, bank: Bank) -> None:
        self.bank = bank
        self.listeners: list[Callable[[Edition], None]] = []
        self._edition: Edition | None = None
        self._lacking = "the kernels are still being compiled"

    async def warm(self) -> None:
        """Warms the first edition in a thread, so that the event loop goes on. If that fails, it stays unready."""
        try:
            edition = await asyncio.to_thread(Edition.warm, self.bank)
        except Exception:
            self._lacking = "the kernels could not be compiled; the service's log says why"
            logger.exception("kernels could not be compiled, so no pose will be served")
        else:
            self.exchange(edition)

    @property
    def ready(self) -> bool:
        """Whether there is an edition."""
        return self._edition is not None

    @property
    def edition(self) -> Edition:
        """The newest edition. Raises NotReadyError until there is one."""
        if self._edition is None:
            raise NotReadyError(self._lacking, mend="Ask /readyz")
        return self._edition

    def exchange(self, edition: Edition) -> None:
        """Serves another edition from now on; on the event loop, between two frames."""
        self.bank, self._edition = edition.bank, edition
        for listener in self.listeners:
            listener(edition)
