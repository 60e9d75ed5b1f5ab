"""The packages of the code: `python -m bench.structure [--picture FILE.png]`.

Prints for each package its modules, their lines, the longest chain of imports among them, and which packages they
import; then the circles of imports. With `--picture`, draws the layers that the import contracts allow instead.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.structure.layers import layers_picture, read_contracts
from bench.structure.package_graph import circles, packages
from motionsplice.cli import run

PROJECT = Path(__file__).parents[2]


def main(
    picture: Annotated[Path | None, typer.Option(help="PNG to draw the layers into")] = None,
) -> None:
    """Prints the packages."""
    if picture is not None:
        picture.write_bytes(layers_picture(read_contracts(PROJECT / "pyproject.toml")))
        return
    table = Table()
    table.add_column("package", no_wrap=True)
    for column in ("modules", "lines", "longest chain", "imports inside"):
        table.add_column(column, justify="right")
    table.add_column("imported packages")
    for package in packages(PROJECT):
        others = ", ".join(one.removeprefix("motionsplice.") for one in package.imported)
        numbers = (package.modules, package.lines, package.longest_chain, package.inside)
        table.add_row(package.name.removeprefix("motionsplice."), *map(str, numbers), others)
    console = Console(width=160)
    console.print(table)
    console.print(f"circles of imports: {circles() or 'none'}", highlight=False)


if __name__ == "__main__":
    run(lambda: typer.run(main))
