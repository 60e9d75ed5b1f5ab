"""The kernels take seconds to compile: until they are warm nothing waits for them, and no pose is served."""

from __future__ import annotations

import asyncio
import logging

from fastapi import HTTPException

from runtime.bank import Bank
from runtime.evaluator import Evaluator

logger = logging.getLogger(__name__)


class Readiness:
    """The evaluator, once its kernels are warm."""

    def __init__(self) -> None:
        self._evaluator: Evaluator | None = None
        self._lacking = "kernels are still being compiled; ask /readyz"

    async def warm(self, bank: Bank) -> None:
        """Makes an evaluator in a thread, so that the event loop goes on. A failure is logged, and stays unready."""
        try:
            self._evaluator = await asyncio.to_thread(_warmed, bank)
        except Exception:
            self._lacking = "kernels could not be compiled; the service's log says why"
            logger.exception("Kernels could not be compiled, so no pose will be served")

    def evaluator(self) -> Evaluator:
        """The evaluator, for the event loop alone. Raises HTTPException 503 until it is warm."""
        if self._evaluator is None:
            raise HTTPException(503, self._lacking)
        return self._evaluator


def _warmed(bank: Bank) -> Evaluator:
    evaluator = Evaluator(bank)
    evaluator.warm()
    return evaluator
