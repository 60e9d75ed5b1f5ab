"""`motionsplice serve`: a bank over HTTP."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from runtime.bank import Bank
from service.server import serve
from service.settings import Settings


def register(app: typer.Typer) -> None:
    app.command("serve", epilog="Example: [bold]motionsplice serve bank --port 8000[/bold]")(serve_command)


def serve_command(
    bank: Annotated[Path, typer.Argument(help="A bank.")],
    host: Annotated[str | None, typer.Option(help="Address to listen on; 127.0.0.1 if not given.")] = None,
    port: Annotated[int | None, typer.Option(min=0, max=65535, help="Port; 8000 if not given.")] = None,
) -> None:
    """Serve a bank's clips, poses and splices over HTTP until stopped.

    Settings may also come from the environment, as MOTIONSPLICE_HOST and so on; flags win.
    """
    settings = Settings()
    port = settings.port if port is None else port
    start(Bank.open(bank), settings.model_copy(update={"host": host or settings.host, "port": port}))


def start(bank: Bank, settings: Settings) -> None:
    """Says where the service will be, and runs it."""
    Console().print(f"Serving {bank.path} at http://{settings.host}:{settings.port}/docs (Ctrl-C ends it)")
    serve(bank, settings)
