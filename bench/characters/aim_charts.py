"""The picture in docs/characters.md of look and aim beside an additive aim offset."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.characters.aim_offset import offset
from bench.characters.aimed import AHEAD, FRAMES, Shown, degrees_apart, gazes, nothing, shown, yaws
from bench.characters.joint_speeds import RATE
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import common_ancestor
from motionsplice.runtime.characters.aim import Aim, Look
from motionsplice.runtime.stage import Stage

LOCOMOTION, ACTION = "run", "push"
FAR = (4.0, 1.6, 40.0)  # metres: a point that stays ahead
START, END = 1.0, 4.0  # seconds
LABELS: dict[str, tuple[str, Any]] = {
    "naive, aim offset": ("#8c8c8c", "naive"),
    "splice, aim offset": ("#4c72b0", "splice"),
    "splice, look and aim": ("#f28c28", None),
}  # row: colour, and the method that the offset is laid on


def aim_chart(stage: Stage) -> bytes:
    """Draws how far head and hands are from what they are to point at, while one runs and pushes. Returns a PNG."""
    figure = Figure(figsize=(12, 3.2), layout="constrained")
    gaze, hands = figure.subplots(1, 2)
    for label, (colour, method) in LABELS.items():
        head_misses, hand_yaws = curves(stage, method)
        draw(gaze, head_misses, colour, label)
        draw(hands, hand_yaws, colour, label)
    gaze.set_title(f"{LOCOMOTION} and {ACTION}: gaze, degrees from a point", fontsize=9)
    hands.set_title("hands, degrees from straight ahead, the chest aimed there", fontsize=9)
    gaze.legend(fontsize=8, frameon=False, loc="upper right", ncols=3)
    gaze.set_ylim(-0.5, 22.0)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=90)
    return file.getvalue()


def curves(stage: Stage, method: Any) -> tuple[Floats, Floats]:
    """Returns the gaze's distance [F] from the point and the hands' yaw [F] from straight ahead, in degrees."""
    roles = stage.bank.roles
    if method is None:
        looks = shown(stage, LOCOMOTION, ACTION, lambda one: one.look([0], Look(FAR)))
        aims = shown(stage, LOCOMOTION, ACTION, lambda one: one.aim([0], Aim(direction=AHEAD, steady=1.0)))
    else:
        clip = shown(stage, LOCOMOTION, ACTION, nothing, method)
        chest = common_ancestor(stage.bank.skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
        looks = offset(stage, clip, roles.head, FAR - clip.places[:, roles.head])
        aims = offset(stage, clip, chest, np.broadcast_to(AHEAD, (FRAMES, 3)))
    return head_misses(stage, looks), np.degrees(yaws(stage, aims) + aims.headings)


def head_misses(stage: Stage, clip: Shown) -> Floats:
    """Returns how far past the point the head looks [F], degrees."""
    return degrees_apart(gazes(stage, clip), FAR - clip.places[:, stage.bank.roles.head])


def draw(axes: Axes, values: Floats, colour: str, label: str) -> None:
    """Draws a curve from START to END."""
    times = np.arange(FRAMES) / RATE
    part = (times >= START) & (times <= END)
    axes.plot(times[part], values[part], color=colour, label=label)
    axes.set_xlabel("seconds")
    axes.spines[["top", "right"]].set_visible(False)
