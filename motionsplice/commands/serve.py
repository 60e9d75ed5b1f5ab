"""`motionsplice serve`: a bank over HTTP. The server is imported when it starts, so that `--help` is fast."""

from __future__ import annotations

import inspect
import types
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import typer
from pydantic import SecretStr
from rich.console import Console
from rich.table import Table

from motionsplice.motion.errors import SettingsError
from motionsplice.motion.storage.place import place_of
from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import PREFIX, Settings

EPILOG = "Example: [bold]motionsplice serve bank --port 8000 --watch[/bold]"
TEXT = (SecretStr, tuple, Path)  # types of settings that flags give as text; an empty path would be the folder `.`


def register(app: typer.Typer) -> None:
    app.command("serve", epilog=EPILOG)(serve_command)


def serve_command(bank: str, **flags: Any) -> None:
    """Serve a bank's clips, poses, splices and streams over HTTP until stopped.

    Settings are also read from the environment, as MOTIONSPLICE_HOST and so on. Flags override it.
    """
    _refuse_windows()
    given = {name: value for name, value in flags.items() if value is not None}
    settings, place = Settings(**given), place_of(bank)
    if isinstance(place, Path):
        start(place, settings)
        return
    from motionsplice.commands.copied_bank import copied
    from motionsplice.service.exchange.copies import folder_for

    if settings.clips is not None:
        mend = "Serve a folder, or run `motionsplice precompute --out URL` where the clips are"
        problem = "uploaded clips cannot be added to a bank at a URL"
        raise SettingsError(problem, file=f"--clips {settings.clips}", mend=mend)
    folder = folder_for(place.url, settings.copies)
    with copied(place, folder, follow=settings.watch):
        start(folder, settings)


def start(bank: Path, settings: Settings) -> None:
    """Verifies a bank, prints its address and settings, and serves it until stopped. Raises MotionError."""
    _refuse_windows()
    from motionsplice.service.server import listen, serve

    if settings.clips is not None and not settings.clips.is_dir():
        raise SettingsError("the folder of clips was not found", file=f"--clips {settings.clips}", mend="Create it")
    digest, console = Bank.open(bank).digest, Console(emoji=False)
    listener = listen(settings)
    port = listener.getsockname()[1]
    table = Table("setting", "", box=None, pad_edge=False)
    for name in Settings.model_fields:
        table.add_row(name, str(getattr(settings, name)))
    console.print(table)
    host = f"[{settings.host}]" if ":" in settings.host else settings.host
    console.print(f"bank {digest}", highlight=False)
    console.print(f"Serving {bank} at http://{host}:{port}/view (stop with Ctrl-C)", highlight=False, soft_wrap=True)
    serve(bank, settings, listener)


def _refuse_windows() -> None:
    if find_spec("fcntl") is None:
        raise SettingsError("the service does not run on Windows", mend="Run it in WSL, or in the container")


def _signature() -> inspect.Signature:
    """Returns a flag for each setting. All are optional, since the environment may set them."""
    hints = get_type_hints(Settings)
    argument = Annotated[str, typer.Argument(help="A bank, as `precompute` wrote it: a folder or a URL.")]
    parameters = [inspect.Parameter("bank", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=argument)]
    for name, field in Settings.model_fields.items():
        kind, metavar = _flag_type(hints[name]), "<path>" if hints[name] == Path | None else None
        text = f"{field.description}. {PREFIX}{name.upper()}"
        option = typer.Option(help=text, metavar=metavar, show_default=False)
        parameters.append(
            inspect.Parameter(
                name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=Annotated[kind | None, option]
            )
        )
    return inspect.Signature(parameters)


def _flag_type(hint: Any) -> type:
    """Returns the type of a setting's flag: str if Settings parses the text itself."""
    while get_origin(hint) is Annotated:
        hint = get_args(hint)[0]
    if get_origin(hint) in (types.UnionType,):
        hint = next(one for one in get_args(hint) if one is not type(None))
    plain = get_origin(hint) or hint
    return str if plain in TEXT else plain


serve_command.__signature__ = _signature()  # type: ignore[attr-defined]
