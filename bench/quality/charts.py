"""The charts of the quality report, each returned as a PNG."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.quality.measures import neck_over_root, upper_body_errors
from bench.quality.rhythm import swing
from bench.quality.scores import PairScore, Spliced
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.pointcloud import level, planar_distances
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.alignment.working_rate import WORKING_RATE
from motionsplice.runtime.bank import Bank

# Okabe and Ito's palette, suitable for colour-blind readers.
COLOURS = {
    "naive": "#d55e00",
    "additive": "#e69f00",
    "exact": "#cc79a7",
    "splice": "#0072b2",
    "truth": "#222222",
    "own": "#999999",
}
WORST = 20.0  # cm, the end of the colour scale


def overview(errors: Mapping[str, Mapping[str, Floats]], rate: float) -> bytes:
    """Draws the error over time: a strip per pair and method, coloured by the error in cm.

    errors: by pair and method, the errors [F] in cm at `rate` frames per second.
    """
    rows = [(pair, method, one) for pair, methods in errors.items() for method, one in methods.items()]
    longest = max(len(one) for _, _, one in rows)
    image = np.full((len(rows), longest), np.nan)
    for row, (_, _, one) in enumerate(rows):
        image[row, : len(one)] = one
    figure = Figure(figsize=(12, 0.9 + 0.21 * len(rows)), layout="constrained")
    axes = figure.subplots()
    strips = axes.imshow(
        image, aspect="auto", cmap="magma_r", vmin=0.0, vmax=WORST, interpolation="nearest",
        extent=(0.0, longest / rate, len(rows) - 0.5, -0.5),
    )  # fmt: skip
    axes.set_yticks(range(len(rows)), [f"{pair}   {method}" for pair, method, _ in rows], fontsize=8)
    for row in range(len(next(iter(errors.values()))), len(rows), len(next(iter(errors.values())))):
        axes.axhline(row - 0.5, color="white", linewidth=3)
    axes.set_xlabel("seconds")
    figure.colorbar(strips, ax=axes, label="error, cm", fraction=0.025, extend="max")
    return _png(figure)


def ratio_grid(scores: Sequence[PairScore], method: str) -> bytes:
    """Draws the ratio of a method's error to the naive splice's, for each action (column) on each locomotion (row)."""
    locomotions, actions = (
        list(dict.fromkeys(getattr(one, part) for one in scores)) for part in ("locomotion", "action")
    )
    image = np.full((len(locomotions), len(actions)), np.nan)
    for one in scores:
        image[locomotions.index(one.locomotion), actions.index(one.action)] = one.of(method).ratio
    figure = Figure(figsize=(1.6 + 0.95 * len(actions), 1.0 + 0.42 * len(locomotions)), layout="constrained")
    axes = figure.subplots()
    axes.imshow(image, aspect="auto", cmap="RdYlGn_r", vmin=0.0, vmax=1.4)
    for (row, column), ratio in np.ndenumerate(image):
        if np.isfinite(ratio):
            axes.text(column, row, f"{ratio:.2f}", ha="center", va="center", fontsize=9)
    axes.set_xticks(range(len(actions)), actions, fontsize=9)
    axes.set_yticks(range(len(locomotions)), locomotions, fontsize=9)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return _png(figure)


def pair_chart(bank: Bank, locomotion: str, action: str, truth: Clip | None, splices: Sequence[Spliced]) -> bytes:
    """Draws four panels for one pair.

    The panels are the grid of distances between the legs, with the alignments drawn through it (Heck et al. 2006,
    Figure 3); the error over time; the neck's distance from the vertical through the root (thesis, Figure 4.5); and the
    swing of the left hand and the right knee (thesis, Figure 4.4).
    """
    figure = Figure(figsize=(12, 6.2), layout="constrained")
    panels = figure.subplot_mosaic([["grid", "error"], ["grid", "neck"], ["swing", "swing"]], width_ratios=(1, 2))
    _draw_grid(panels["grid"], bank, locomotion, action, splices)
    clip_l = bank.motion(locomotion)
    seconds = np.arange(clip_l.frame_count) / clip_l.rate
    for one in splices:
        if truth is not None:
            errors = 100.0 * upper_body_errors(one.clip, truth, bank.roles).mean(axis=1)
            panels["error"].plot(seconds[: len(errors)], errors, color=COLOURS[one.form.how], label=one.form.label)
    panels["error"].set(title="error, cm" if truth else "error: truth unknown", ylim=(0.0, None))
    reference = ("truth", truth) if truth is not None else ("own", clip_l)
    named = [(one.form.how, one.clip) for one in splices if one.form.how != "exact"]
    for name, clip in (*named, reference):
        neck = 100.0 * neck_over_root(clip, bank.roles)
        panels["neck"].plot(seconds[: len(neck)], np.hypot(neck[:, 0], neck[:, 2]), color=COLOURS[name], label=name)
        hand = 100.0 * swing(clip, bank.roles, "left_wrist", "left_shoulder")
        panels["swing"].plot(seconds[: len(hand)], hand, color=COLOURS[name], label=f"left hand, {name}")
    panels["neck"].set(title="horizontal distance of the neck from the root, cm")
    knee = 100.0 * swing(clip_l, bank.roles, "right_knee")
    panels["swing"].plot(seconds, knee, color="#009e73", linestyle="--", label="right knee")
    panels["swing"].set(title="left hand ahead of its shoulder, right knee ahead of the root, cm", xlabel="seconds")
    for name in ("error", "neck", "swing"):
        panels[name].spines[["top", "right"]].set_visible(False)
        panels[name].margins(x=0.0)
        if panels[name].lines:
            low, high = panels[name].get_ylim()
            panels[name].set_ylim(low, high + 0.25 * (high - low))  # room for the legend
            panels[name].legend(fontsize=8, ncols=4, frameon=False, loc="upper right")
    return _png(figure)


def _draw_grid(axes: Axes, bank: Bank, locomotion: str, action: str, splices: Sequence[Spliced]) -> None:
    """Draws the distance grid, dark where the legs are close, with a line per alignment.

    A line is interrupted where its alignment goes back by whole strides.
    """
    clips = bank.motion(locomotion), bank.motion(action, seam=True)
    cloud = list(bank.roles.lower_cloud)
    clouds = (level(joint_positions(clip.resampled(WORKING_RATE))[:, cloud]) for clip in clips)
    grid = 100.0 * np.sqrt(planar_distances(*clouds) / len(cloud))
    extent = (0.0, clips[0].duration, 0.0, clips[1].duration)
    axes.imshow(grid.T, origin="lower", cmap="gray", extent=extent, aspect="auto", interpolation="nearest")
    for one in splices:
        if one.action_frames is not None:
            seconds = np.arange(len(one.action_frames)) / clips[0].rate
            action_seconds = one.action_frames / clips[1].rate
            back = np.diff(action_seconds, append=action_seconds[-1]) < 0.0
            action_seconds = np.where(back, np.nan, action_seconds)
            axes.plot(seconds, action_seconds, color=COLOURS[one.form.how], linewidth=1.8, label=one.form.label)
    axes.set(title="distance between the legs", xlabel=f"{locomotion}, seconds", ylabel=f"{action}, seconds")
    axes.legend(fontsize=8, loc="upper left")


def _png(figure: Figure) -> bytes:
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=90)
    return file.getvalue()
