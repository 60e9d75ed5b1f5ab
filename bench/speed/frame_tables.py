"""The tables that `bench.speed.frames` prints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.console import Console
from rich.table import Table

from bench.rounds import Summary
from bench.speed.roofline import Roofline

TITLES = {
    "batches": "Warm batches: many pairs, random times",
    "scenes": "Warm batches: one pair or many, sequential or random times",
    "forms": "Warm batches: postures, and world positions of poses",
    "threads": "Warm batches on several threads",
    "cold": "Cold batches: caches emptied before each call",
    "paced": "60 Hz ticks, with sleep in between",
    "single": "Single calls of one character, Python included",
    "libraries, random times": "Warm batches at random times: the kernels, and libraries in C",
    "libraries, sequential times": "Warm batches at sequential times: the kernels, and libraries in C",
}


def show(about: Mapping[str, float], tables: Mapping[str, Sequence[Summary]], roof: Roofline) -> None:
    """Prints all tables. Times are per character and frame."""
    console = Console(width=110)
    console.print(
        f"{about['clips']} clips, {about['seconds']:.0f} s of motion, {about['joints']} joints, "
        f"{about['bytes'] / 1e6:.1f} MB. Times are nanoseconds per character and frame."
    )
    for name, rows in tables.items():
        console.print(summary_table(TITLES[name], rows))
    console.print(roofline_table(roof, tables["batches"]))


def summary_table(title: str, rows: Sequence[Summary]) -> Table:
    """A table with a row per summary: nanoseconds and ratios. Lines separate the batch sizes."""
    table = Table(title=title, title_justify="left")
    against = list(rows[0].ratios)
    for column in ("characters", "", "median", "p95", "p99", "slowest", *(f"/ {other}" for other in against)):
        table.add_column(column, justify="left" if not column else "right")
    before = rows[0].characters
    for one in rows:
        if one.characters != before:
            table.add_section()
        before = one.characters
        times = (f"{1e9 * time:,.0f}" for time in (one.median, one.p95, one.p99, one.worst))
        table.add_row(f"{one.characters:,}", one.what, *times, *(_ratio(one.ratios[other]) for other in against))
    return table


def _ratio(value: float) -> str:
    """Two digits at least: 1.45, 0.98, 0.052."""
    return f"{value:.3f}" if value < 0.1 else f"{value:.2f}"


def roofline_table(roof: Roofline, batches: Sequence[Summary]) -> Table:
    """A table of the time that memory or arithmetic alone would need for a splice, and the measured time."""
    table = Table(title="Roofline of a splice, one core", title_justify="left")
    for column in ("", "per character and frame", "this machine, per second", "ns"):
        table.add_column(column, justify="right" if column else "left")
    table.add_row(
        "bytes, from memory", f"{roof.bytes:,}", f"{roof.memory / 1e9:.1f} GB", f"{1e9 * roof.from_memory:,.0f}"
    )
    table.add_row(
        "bytes, within the cache", f"{roof.bytes:,}", f"{roof.cache / 1e9:.1f} GB", f"{1e9 * roof.from_cache:,.0f}"
    )
    table.add_row(
        "operations", f"{roof.operations:,}", f"{roof.arithmetic / 1e9:.1f} G", f"{1e9 * roof.computing:,.0f}"
    )
    measured = [one for one in batches if one.what == "splice"]
    for one in measured:
        table.add_row(f"measured, batch of {one.characters:,}", "", "", f"{1e9 * one.median:,.0f}")
    return table
