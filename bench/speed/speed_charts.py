"""The chart of docs/performance.md."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.quality.charts import COLOURS
from bench.rounds import Summary
from bench.speed.flatness import Series

FLOOR = "#999999"
METHODS = {"splice": COLOURS["splice"], "naive": COLOURS["naive"], "copy": FLOOR}


def speed_chart(series: Sequence[Series], batches: Sequence[Summary]) -> bytes:
    """Draws nanoseconds per character and frame by clip length, clips in the bank, and batch size. Returns a PNG."""
    figure = Figure(figsize=(12, 3.8), layout="constrained")
    panels = figure.subplots(1, 3)
    titles = {"clip length": "clip length, seconds", "clips in the bank": "clips in the bank"}
    for axes, (subject, label) in zip(panels, titles.items(), strict=False):
        for one in series:
            if one.name.startswith(subject):
                style = "-" if one.name.endswith("same rows") else ":"
                choice = one.name.removeprefix(f"{subject}, ")
                for method, times in (("splice", one.splice), ("naive", one.naive)):
                    axes.plot(
                        one.x,
                        1e9 * np.array(times),
                        style,
                        marker="o",
                        color=METHODS[method],
                        label=f"{method}, {choice}",
                    )
        axes.set_ylim(0.0, None)
        _finish(axes, label)
    for method, colour in METHODS.items():
        own = [one for one in batches if one.what == method]
        sizes, medians = [one.characters for one in own], [1e9 * one.median for one in own]
        panels[2].plot(sizes, medians, marker="o", color=colour, label=method)
    panels[2].set_yscale("log")
    _finish(panels[2], "characters in the batch")
    panels[0].set_ylabel("ns per character and frame")
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=90)
    return file.getvalue()


def _finish(axes: Axes, label: str) -> None:
    axes.set_xscale("log")
    axes.set_xlabel(label)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(fontsize=8, frameon=False)
