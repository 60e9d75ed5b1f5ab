"""Charts of a study: curves correlated with the legs, globally and locally (Heck's thesis, Figures 4.2 and 4.3)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motionsplice.pictures.brush import Colour, mixed
from motionsplice.pictures.stick_figure import LEFT, RIGHT
from motionsplice.precompute.study.body_angles import Axis, Curve, View
from motionsplice.precompute.study.correlation import Study
from motionsplice.precompute.study.periodic import trend

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito's palette, with the two colours of the stick figures, without yellow, which is invisible on white.
GREEN: Colour = (0, 158, 115)
ORANGE: Colour = (230, 159, 0)
PURPLE: Colour = (204, 121, 167)
SKY: Colour = (86, 180, 233)
PALETTE = (LEFT, ORANGE, GREEN, PURPLE, SKY, RIGHT)
BAND, LINE, QUIET = "#f1f3f5", "#c9ced4", "#767d86"
FAINT = 0.55  # fraction of white in a data line
ROOM = 0.15  # margin above and below the trends, relative to their height

SIZE, DPI = (11.0, 8.6), 100
TITLES = {
    View.GLOBAL: "global orientations, relative to the direction of travel",
    View.LOCAL: "local orientations, relative to the parent joint",
}
AXES = {Axis.BEND: "bend (forward +)", Axis.TWIST: "twist (to the left +)", Axis.LEAN: "lean (to the right +)"}


def draw_chart(study: Study, view: View, file: Path) -> None:
    """Writes a PNG with one column per axis and one row per body part, below a row with the swing of the thighs.

    Data lines are faint, their trends strong; curves that do not correlate with the legs are left out. Bands mark when
    the left thigh is ahead.
    """
    from matplotlib.figure import Figure  # takes a second to import, which other commands do not need

    figure = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
    found = {(one.joint, one.axis): one for one in (item.curve for item in study.found.values()) if one.view is view}
    parts = _parts([item.curve for item in study.correlations if item.curve.view is view])
    grid = figure.subplots(1 + len(parts), len(Axis), sharex=True, squeeze=False)
    figure.suptitle(f"{study.name}: {TITLES[view]}", x=0.01, ha="left", fontsize=13)
    for panel, axis in zip(grid[0], Axis, strict=True):
        panel.set_title(AXES[axis], fontsize=11, loc="left")
        for side, colour, swing in zip(("left thigh", "right thigh"), (LEFT, RIGHT), study.thighs, strict=True):
            panel.plot(study.seconds, np.degrees(swing), color=shade(colour), linewidth=1.6, label=side)
    for panels, (part, joints) in zip(grid[1:], parts.items(), strict=True):
        for panel, axis in zip(panels, Axis, strict=True):
            curves = {joint: found[joint, axis] for joint in joints if (joint, axis) in found}
            _draw_curves(panel, study, curves, joints)
        for joint, colour in joints.items():
            if any((joint, axis) in found for axis in Axis):
                panels[-1].plot([], [], color=shade(colour), linewidth=2.0, label=joint)
        panels[0].set_ylabel(f"{part}, degrees", fontsize=9)
    grid[0, 0].set_ylabel("hips' swing, degrees", fontsize=9)
    for panel in grid.flat:
        _furnish(panel, study)
    for panel in grid[:-1].flat:
        panel.tick_params(axis="x", length=0)
    for panels in grid:
        if panels[-1].get_legend_handles_labels()[0]:
            panels[-1].legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=9)
    for panel in grid[-1]:
        panel.set_xlabel("seconds; bands: left thigh ahead", fontsize=9)
    figure.align_ylabels(grid[:, 0])
    figure.savefig(file)


def _draw_curves(panel: Axes, study: Study, curves: dict[str, Curve], colours: dict[str, Colour]) -> None:
    """Draws data lines and trends; later ones are thinner, so that none hides another."""
    if not curves:
        panel.text(0.5, 0.5, "nothing correlates with the legs", color=QUIET, fontsize=9, ha="center", va="center",
                   transform=panel.transAxes)  # fmt: skip
        panel.set_yticks([])
        return
    trends = {joint: np.degrees(trend(curve.angles, study.phase)) for joint, curve in curves.items()}
    for joint, curve in curves.items():
        colour = shade(mixed(colours[joint], FAINT))
        panel.plot(study.seconds, np.degrees(curve.angles), color=colour, linewidth=0.9)
    for width, (joint, line) in zip(np.linspace(2.4, 1.2, len(trends)), trends.items(), strict=True):
        panel.plot(study.seconds, line, color=shade(colours[joint]), linewidth=width)
    low, high = (float(limit(list(trends.values()))) for limit in (np.min, np.max))
    panel.set_ylim(
        low - ROOM * (high - low), high + ROOM * (high - low)
    )  # by the trends, because a spike in the data would flatten everything else
    panel.axhline(0.0, color=LINE, linewidth=0.8, zorder=1)


def _parts(curves: list[Curve]) -> dict[str, dict[str, Colour]]:
    """Returns the joints of each row, with their colours."""
    joints = list(dict.fromkeys(curve.joint for curve in curves))
    arms = {side: [joint for joint in joints if joint.startswith(side)] for side in ("left", "right")}
    head = [joint for joint in joints if joint.startswith(("neck", "head"))]
    trunk = [joint for joint in joints if joint not in {*arms["left"], *arms["right"], *head}]
    rows = {"trunk": trunk, "neck and head": head, "left arm": arms["left"], "right arm": arms["right"]}
    return {
        part: {joint: PALETTE[number % len(PALETTE)] for number, joint in enumerate(members)}
        for part, members in rows.items()
        if members
    }


def _furnish(panel: Axes, study: Study) -> None:
    """Draws the bands and mutes the axes."""
    ahead = np.cos(2.0 * np.pi * study.phase) > 0.0
    panel.fill_between(study.seconds, 0, 1, where=ahead, color=BAND, transform=panel.get_xaxis_transform(), zorder=0)
    panel.set_xlim(0.0, study.seconds[-1])
    panel.locator_params(axis="y", nbins=4)
    panel.tick_params(labelsize=8, color=LINE, labelcolor=QUIET)
    for side, spine in panel.spines.items():
        spine.set_visible(side == "left")
        spine.set_color(LINE)


def shade(colour: Colour) -> str:
    """Returns a colour in hexadecimal notation, as Matplotlib takes it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
