"""Running the service."""

from __future__ import annotations

import uvicorn

from runtime.bank import Bank
from service.app import create_app
from service.settings import Settings


def serve(bank: Bank, settings: Settings) -> None:
    """Serves a bank until stopped."""
    uvicorn.run(create_app(bank, settings), host=settings.host, port=settings.port)
