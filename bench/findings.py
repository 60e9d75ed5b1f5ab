"""What was measured, beside what is wanted."""

from __future__ import annotations

from dataclasses import dataclass, field

from rich.console import Console
from rich.table import Table


@dataclass
class Findings:
    """Rows of a table; a row that misses what is wanted is remembered."""

    title: str
    rows: list[tuple[str, str, str]] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)

    def add(
        self,
        label: str,
        value: float,
        form: str = "{:.2f}",
        *,
        most: float | None = None,
        least: float | None = None,
    ) -> None:
        """A number, and the most or least that it should be."""
        wanted = "" if most is None and least is None else f"≤ {most:g}" if most is not None else f"≥ {least:g}"
        if (most is not None and value > most) or (least is not None and value < least):
            self.missed.append(f"{self.title}: {label} is {form.format(value)}, wanted {wanted}")
            wanted = f"[red]{wanted}[/red]"
        self.rows.append((label, form.format(value), wanted))

    def show(self) -> None:
        table = Table(title=self.title, title_justify="left")
        table.add_column("")
        table.add_column("found", justify="right")
        table.add_column("wanted", justify="right")
        for row in self.rows:
            table.add_row(*row)
        Console(width=110).print(table)
