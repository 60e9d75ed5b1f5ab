"""The rooms of the code: `python -m bench.structure [--picture FILE.png]`.

Prints for each room its modules, their lines, the longest chain of imports among them, and which rooms they import; and
circles of imports, if there are any. With `--picture`, draws the layers that the import contracts allow.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.structure.layers import layers_picture, read_contracts
from bench.structure.rooms import circles, rooms
from motionsplice.cli import run

PROJECT = Path(__file__).parents[2]


def main(
    picture: Annotated[Path | None, typer.Option(help="PNG to draw the layers into")] = None,
) -> None:
    """Prints the rooms."""
    if picture is not None:
        picture.write_bytes(layers_picture(read_contracts(PROJECT / "pyproject.toml")))
        return
    found = rooms(PROJECT)
    table = Table()
    table.add_column("room", no_wrap=True)
    for column in ("modules", "lines", "floors", "imports inside"):
        table.add_column(column, justify="right")
    table.add_column("imports of rooms")
    for room in found:
        others = ", ".join(one.removeprefix("motionsplice.") for one in room.rooms)
        numbers = (room.modules, room.lines, room.floors, room.inside)
        table.add_row(room.name.removeprefix("motionsplice."), *map(str, numbers), others)
    console = Console(width=160)
    console.print(table)
    console.print(f"circles of imports: {circles() or 'none'}", highlight=False)


if __name__ == "__main__":
    run(lambda: typer.run(main))
