"""What the benchmarks of the service print."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from bench.targets import Target

MEGABYTE = 1e6
console = Console(width=120)


def show(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Prints a table whose first column names the rows."""
    table = Table(title=title, title_justify="left")
    for number, column in enumerate(columns):
        table.add_column(column, justify="right" if number else "left")
    for row in rows:
        table.add_row(*row)
    console.print(table)


def show_targets(found: Sequence[Target]) -> None:
    """Prints what was wanted, and whether it is so."""
    told = [[one.what, f"[{'green' if one.met else 'red'}]{one.found}[/]", one.wanted] for one in found]
    show("Targets", ["what", "found", "wanted"], told)


def at_most(what: str, value: float, most: float) -> Target:
    return Target(what, f"{value:,.4g}", f"<= {most:,g}", bool(value <= most))


def at_least(what: str, value: float, least: float) -> Target:
    return Target(what, f"{value:,.4g}", f">= {least:,g}", bool(value >= least))


def milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.2f}"


def percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"
