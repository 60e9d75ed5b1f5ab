"""Running the service."""

from __future__ import annotations

import uvicorn

from runtime.bank import Bank
from service.app import create_app
from service.settings import Settings

LAST_SECONDS = 3  # that streams have when the service is told to stop: a paced one may have minutes to go


def serve(bank: Bank, settings: Settings) -> None:
    """Serves a bank until stopped."""
    app = create_app(bank, settings)
    uvicorn.run(app, host=settings.host, port=settings.port, timeout_graceful_shutdown=LAST_SECONDS)
