"""Charts of how hands were aligned: costs, bands and paths of both passes, and the curves after alignment.

Majkowska, Zordan and Faloutsos 2006, figures 2 to 4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Side
from motionsplice.pictures.correlation_charts import GREEN, LINE, ORANGE, QUIET, SKY, shade
from motionsplice.pictures.stick_figure import LEFT, RIGHT
from motionsplice.precompute.hands.align import Pass
from motionsplice.precompute.hands.banded_warp import FramePair
from motionsplice.precompute.hands.phases import PhaseKind, phases
from motionsplice.precompute.hands.points import LITTLE_SIDE, THUMB_SIDE, HandMotion, bones
from motionsplice.precompute.hands.settings import HandSettings
from motionsplice.precompute.hands.splice import AlignedHands, HandSplice

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

DPI = 100
ROW, WIDTH = 4.6, 13.5  # inches, for each alignment
PIXELS = 700  # at most, along each side of a matrix
PASSES = ("first pass: phases", "second pass: palms and paces too")
KIND_COLOURS: Mapping[PhaseKind, str] = {
    "hold": LINE,
    "preparation": shade(SKY),
    "stroke": shade(ORANGE),
    "retraction": shade(GREEN),
}
SIDE_COLOURS = {"left": shade(LEFT), "right": shade(RIGHT)}
DARK = "#30363d"


def draw_alignment(spliced: HandSplice, settings: HandSettings, hand_rate: float, file: Path) -> None:
    """Writes a PNG with a row for each alignment: both cost matrices, and each hand's curves before and after.

    hand_rate: frames per second of the hands clip; frame pairs are counted at this rate.
    """
    from matplotlib.figure import Figure  # takes a second to import, which other commands do not need

    heights = [ROW * len(aligned.body) ** 0.5 for aligned in spliced.aligned]
    figure = Figure(figsize=(WIDTH, sum(heights)), dpi=DPI)
    rows = figure.subfigures(len(spliced.aligned), 1, height_ratios=heights, squeeze=False)[:, 0]
    rate = spliced.clip.rate
    for row, aligned in zip(rows, spliced.aligned, strict=True):
        left, right = row.subfigures(1, 2, width_ratios=(1.25, 1.0))
        left.suptitle(f"{' and '.join(aligned.body)}: frames of body and hands", x=0.03, ha="left", fontsize=12)
        panels = left.subplots(1, 2, sharey=True)
        left.subplots_adjust(left=0.09, right=0.99, bottom=0.12, top=0.86, wspace=0.06)
        for panel, title, step in zip(panels, PASSES, aligned.alignment.passes, strict=True):
            _draw_pass(panel, title, step, settings.pairs, rate / hand_rate)
        panels[0].set_ylabel("frame of the hands, at the body's rate", fontsize=9)
        _draw_curves(right, aligned, rate)
    figure.savefig(file)


def _draw_pass(panel: Axes, title: str, step: Pass, pairs: Sequence[FramePair], ratio: float) -> None:
    """Draws the costs of a band's cells (darker is lower), the path, and the given frame pairs."""
    band, count, others = step.band, len(step.band.low), int(step.band.high.max()) + 1
    panel.set_title(title, fontsize=10, loc="left", color=DARK)
    i = np.linspace(0, count - 1, min(count, PIXELS)).round().astype(np.int64)
    j = np.linspace(0, others - 1, min(others, PIXELS)).round().astype(np.int64)[:, None]
    within = (j >= band.low[i]) & (j <= band.high[i])
    costs = step.costs[i, np.clip(j - band.low[i], 0, band.width - 1)]
    least, most = np.percentile(costs[within], [0.5, 99.5])
    extent = (-0.5, count - 0.5, -0.5, others - 0.5)
    masked = np.where(within, costs, np.nan)
    panel.imshow(masked, "bone", origin="lower", extent=extent, vmin=least, vmax=most, aspect="auto")
    panel.plot(*step.path.T, color=shade(ORANGE), linewidth=1.8)
    for pair in pairs:
        reach = [ratio * pair.tolerance]
        panel.errorbar([pair.body], [ratio * pair.hands], reach, fmt="o", color=shade(RIGHT), markersize=5, capsize=3)
    panel.set_xlim(extent[:2])
    panel.set_ylim(extent[2:])
    panel.set_xlabel("frame of the body", fontsize=9)
    _quieten(panel)


def _draw_curves(figure: SubFigure, aligned: AlignedHands, rate: float) -> None:
    """Draws, for each hand, the phases of body and hands, the height of the wrist and the bend of the palm."""
    frames = aligned.alignment.frames
    seconds = np.arange(len(frames)) / rate
    figure.suptitle("body (colour), hands as aligned (black) and as captured (grey)", x=0.02, ha="left", fontsize=12)
    parts = figure.subfigures(len(aligned.body), 1, squeeze=False)[:, 0]
    for part, side in zip(parts, aligned.body, strict=True):
        ours, theirs = aligned.body[side], aligned.hands[side]
        panels = part.subplots(3, 1, sharex=True, height_ratios=(0.3, 1.0, 1.0))
        part.subplots_adjust(left=0.11, right=0.98, bottom=0.12, top=0.84, hspace=0.2)
        _draw_phases(panels[0], side, ours, theirs, frames, rate)
        for panel, label, curve in zip(panels[1:], ("wrist's height", "palm's bend"), (_height, _bend), strict=True):
            own = np.arange(len(theirs.points))
            panel.plot(own / rate, curve(theirs), color=LINE, linewidth=1.0)
            panel.plot(seconds, np.interp(frames, own, curve(theirs)), color=DARK, linewidth=1.2)
            panel.plot(seconds, curve(ours), color=SIDE_COLOURS[side], linewidth=1.8)
            panel.set_ylabel(label, fontsize=8)
            panel.set_yticks([])
            _quieten(panel)
        panels[-1].set_xlim(0.0, max(len(frames) - 1, 1) / rate)
    panels[-1].set_xlabel("seconds of the body", fontsize=9)


def _draw_phases(panel: Axes, side: Side, ours: HandMotion, theirs: HandMotion, frames: Floats, rate: float) -> None:
    """Draws a bar of the body's phases above a bar of the aligned hands' phases."""
    for level, motion in ((1.0, ours), (0.0, theirs)):
        for phase in phases(motion, rate):
            ends = np.array([phase.begin, phase.end], np.float64)
            begin, end = ends if motion is ours else np.searchsorted(frames, ends)
            panel.barh(
                level, (end - begin) / rate, 0.8, begin / rate, color=KIND_COLOURS[phase.kind], edgecolor="white"
            )
    panel.set_yticks([1.0, 0.0], ["body", "hands"], fontsize=7)
    panel.set_title(f"{side} hand", fontsize=9, loc="left", color=SIDE_COLOURS[side])
    for kind, colour in KIND_COLOURS.items():
        panel.bar(0.0, 0.0, color=colour, label=kind)
    panel.legend(ncols=4, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=7, borderpad=0.0)
    _quieten(panel)


def _height(motion: HandMotion) -> Floats:
    """Returns the height of the wrist in its own standard deviations, because hands and bodies differ in size."""
    wrist = motion.points[:, [THUMB_SIDE, LITTLE_SIDE], 1].mean(axis=1)
    return np.asarray((wrist - wrist.mean()) / max(float(wrist.std()), 1e-6))


def _bend(motion: HandMotion) -> Floats:
    """Returns the angle between forearm and palm, radians."""
    forearm, palm = np.moveaxis(bones(motion.points), 1, 0)
    return np.asarray(np.pi - np.arccos(np.clip(np.sum(forearm * palm, axis=1), -1.0, 1.0)))


def _quieten(panel: Axes) -> None:
    panel.tick_params(labelsize=8, color=LINE, labelcolor=QUIET)
    for side, spine in panel.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(LINE)
