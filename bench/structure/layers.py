"""A picture of the layers, drawn from the contracts that import-linter holds the code to."""

from __future__ import annotations

import io
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

FILLS = {
    "bench": "#f3f4f6",
    "motionsplice.precompute": "#e3eefb",
    "motionsplice.service": "#e6f4ea",
    "motionsplice.runtime": "#fdf0dc",
    "motionsplice.motion": "#f4e8f7",
}
PLAIN, EDGE, INK, FAINT = "#f3f4f6", "#9aa0a6", "#202124", "#5f6368"
ROW, TITLE, GAP, WIDTH = 0.34, 0.34, 0.1, 11.0  # inches
POINTS, LETTER = 72.0, 0.62  # points in an inch; width of a letter, relative to its size
Rows = list[list[str]]


@dataclass(frozen=True)
class Contract:
    """Layers from the highest to the lowest: what stands higher may import what stands lower."""

    name: str
    containers: tuple[str, ...]
    rows: Rows


def read_contracts(pyproject: Path) -> list[Contract]:
    """Reads the contracts about layers from a `pyproject.toml`."""
    document: dict[str, Any] = tomllib.loads(pyproject.read_text(encoding="utf-8"))
    return [
        Contract(
            contract["name"],
            tuple(contract.get("containers", ())),
            [[part.strip() for part in layer.split("|")] for layer in contract["layers"]],
        )
        for contract in document["tool"]["importlinter"]["contracts"]
        if contract["type"] == "layers"
    ]


def layers_picture(contracts: list[Contract]) -> bytes:
    """Draws a PNG of the project's layers, and inside each package its own layers."""
    project = next(contract for contract in contracts if not contract.containers)
    inner = {container: contract.rows for contract in contracts for container in contract.containers}
    heights = [max(_height(name, inner) for name in row) for row in project.rows]
    height = sum(heights) + GAP * (len(heights) + 1) + TITLE
    figure = Figure(figsize=(WIDTH, height), dpi=110)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, WIDTH)
    axes.set_ylim(height, 0.0)
    axes.axis("off")
    axes.text(WIDTH / 2.0, 0.25, "what stands higher may import what stands lower", color=FAINT, ha="center", size=10)
    top = TITLE + GAP
    for row, tall in zip(project.rows, heights, strict=True):
        wide = (WIDTH - GAP * (len(row) + 1)) / len(row)
        for number, name in enumerate(row):
            _draw_package(axes, name, inner.get(name), (GAP + number * (wide + GAP), top, wide, tall))
        top += tall + GAP
    sink = io.BytesIO()
    figure.savefig(sink, format="png")
    return sink.getvalue()


def _height(name: str, inner: dict[str, Rows]) -> float:
    return TITLE + len(inner.get(name, ())) * ROW + (GAP if name in inner else 0.0)


def _draw_package(axes: Axes, name: str, rows: Rows | None, box: tuple[float, float, float, float]) -> None:
    left, top, wide, tall = box
    _draw_box(axes, box, FILLS.get(name, PLAIN))
    label = name.removeprefix("motionsplice.").replace("_", " ")
    middle = top + (TITLE if rows else tall) / 2.0
    axes.text(left + wide / 2.0, middle, label, color=INK, ha="center", va="center", size=11, weight="bold")
    for number, row in enumerate(rows or ()):
        step = (wide - GAP) / len(row)
        for place, one in enumerate(row):
            cell = (left + GAP + place * step, top + TITLE + number * ROW, step - GAP, ROW - 0.06)
            _draw_box(axes, cell, "#ffffff")
            centre = cell[0] + cell[2] / 2.0, cell[1] + cell[3] / 2.0
            fitting = POINTS * cell[2] / (LETTER * len(one))
            axes.text(*centre, one, color=INK, ha="center", va="center", size=min(9.0, fitting))


def _draw_box(axes: Axes, box: tuple[float, float, float, float], fill: str) -> None:
    left, top, wide, tall = box
    style = "round,pad=0,rounding_size=0.05"
    axes.add_patch(
        FancyBboxPatch((left, top), wide, tall, boxstyle=style, facecolor=fill, edgecolor=EDGE, linewidth=0.8)
    )
