"""A table of measurements, each beside its target."""

from __future__ import annotations

from dataclasses import dataclass, field

from rich.console import Console
from rich.table import Table


@dataclass
class Findings:
    """Rows of a table: label, value, target. `missed` holds a sentence for each value that misses its target."""

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
        """Adds a measurement. Its target is an upper bound, `most`, or a lower bound, `least`, or neither."""
        target = "" if most is None and least is None else f"≤ {most:g}" if most is not None else f"≥ {least:g}"
        if (most is not None and value > most) or (least is not None and value < least):
            self.missed.append(f"{self.title}: {label} is {form.format(value)}, target {target}")
            target = f"[red]{target}[/red]"
        self.rows.append((label, form.format(value), target))

    def show(self) -> None:
        """Prints the table."""
        table = Table(title=self.title, title_justify="left")
        table.add_column("")
        table.add_column("measured", justify="right")
        table.add_column("target", justify="right")
        for row in self.rows:
            table.add_row(*row)
        Console(width=110).print(table)
