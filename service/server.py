"""Running the service."""

from __future__ import annotations

from pathlib import Path

import uvicorn

from runtime.bank import Bank
from service.app import create_app
from service.settings import Settings


def serve(bank: Path, settings: Settings) -> None:
    """Serves a bank until stopped. Raises BankError before it listens if the bank is unsound."""
    uvicorn.run(create_app(Bank.open(bank), settings), host=settings.host, port=settings.port)
