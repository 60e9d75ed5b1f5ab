"""`motionsplice serve`: a bank over HTTP."""

from __future__ import annotations

import inspect
import types
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import typer
from pydantic import SecretStr
from rich.console import Console
from rich.table import Table

from motionsplice.runtime.bank import Bank
from motionsplice.service.server import listen, serve
from motionsplice.service.settings import PREFIX, Settings

EPILOG = "Example: [bold]motionsplice serve bank --port 8000 --watch[/bold]"
TEXT = (SecretStr, tuple)  # types of settings that are given as text


def register(app: typer.Typer) -> None:
    app.command("serve", epilog=EPILOG)(serve_command)


def serve_command(bank: Path, **flags: Any) -> None:
    """Serve a bank's clips, poses, splices and streams over HTTP until stopped.

    Settings may also come from the environment, as MOTIONSPLICE_HOST and so on; flags win.
    """
    given = {name: value for name, value in flags.items() if value is not None}
    start(bank, Settings(**given))


def start(bank: Path, settings: Settings) -> None:
    """Verifies a bank, says where it is served and with which settings, and serves it until stopped."""
    digest, console = Bank.open(bank).digest, Console(emoji=False)
    listener = listen(settings)
    port = listener.getsockname()[1]
    table = Table("setting", "", box=None, pad_edge=False)
    for name in Settings.model_fields:
        table.add_row(name, str(getattr(settings, name)))
    console.print(table)
    host = f"[{settings.host}]" if ":" in settings.host else settings.host
    console.print(f"bank {digest}", highlight=False)
    console.print(f"Serving {bank} at http://{host}:{port}/docs (Ctrl-C ends it)", highlight=False, soft_wrap=True)
    serve(bank, settings, listener)


def _signature() -> inspect.Signature:
    """One flag for each setting, so that none is forgotten; all are optional, for the environment may have them."""
    hints = get_type_hints(Settings)
    argument = Annotated[Path, typer.Argument(help="A bank.")]
    parameters = [inspect.Parameter("bank", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=argument)]
    for name, field in Settings.model_fields.items():
        kind = _flag_type(hints[name])
        option = typer.Option(help=f"{field.description}. {PREFIX}{name.upper()}", show_default=False)
        parameters.append(
            inspect.Parameter(
                name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=Annotated[kind | None, option]
            )
        )
    return inspect.Signature(parameters)


def _flag_type(hint: Any) -> type:
    """The type of a setting as a flag: text for what the settings read from text themselves."""
    while get_origin(hint) is Annotated:
        hint = get_args(hint)[0]
    if get_origin(hint) in (types.UnionType,):
        hint = next(one for one in get_args(hint) if one is not type(None))
    plain = get_origin(hint) or hint
    return str if plain in TEXT else plain


serve_command.__signature__ = _signature()  # type: ignore[attr-defined]
