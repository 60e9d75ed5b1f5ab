"""The picture of feet in docs/characters.md."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bench.characters.crossfade import crossfade
from bench.characters.feet import standing_feet, without_feet
from bench.characters.joint_speeds import RATE, character_positions
from bench.characters.slides import DRIVEN, FADE, LOCKED, PATHS, PLAIN, SIDEWAYS, WAYS, fade, stances_of_changes
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.stage import Stage

COLOURS = {PLAIN: "#8c8c8c", PATHS: "#c44e52", DRIVEN: "#4c72b0", LOCKED: "#55a868"}
SIDES = ("left", "right")
CHANGE = ("run", "walk", 0.15)  # from, to, and seconds into the first clip at which it is played before the change
BEFORE, AFTER = 40, 60  # frames drawn before and after the change
MOST = 20.0  # centimetres of the axis of slides


def slide_chart(stage: Stage) -> bytes:
    """Draws the feet of one change of locomotion from above, and the slides of all changes. Returns a PNG."""
    figure = Figure(figsize=(12, 4.6), layout="constrained")
    steps = figure.add_gridspec(1, 3)
    tracks, slides = figure.add_subplot(steps[0, :2]), figure.add_subplot(steps[0, 2])
    for row, way in enumerate((PLAIN, *WAYS)):
        draw_tracks(tracks, stage, way, 0.9 * row)
        found, pairs = stances_of_changes(stage, way)
        ahead = [one for one in found if SIDEWAYS not in {clip.name for clip in pairs[one.character]}]
        centimetres = np.sort([100.0 * one.slide for one in ahead])
        slides.plot(centimetres, np.linspace(0.0, 100.0, len(centimetres)), color=COLOURS[way], label=way)
    first, second, _ = CHANGE
    tracks.set_title(f"toes from above, {first} to {second} in {FADE:g} s; thick where they stand", fontsize=9)
    tracks.set_xlabel("metres ahead")
    tracks.set_yticks([])
    tracks.set_aspect("equal")
    tracks.spines[["top", "right", "left"]].set_visible(False)
    slides.set_title("all changes but to and from a side-step", fontsize=9)
    slides.set_xlabel("slide of a stance, at most so many centimetres")
    slides.set_ylabel("stances, %")
    slides.set_xlim(0.0, MOST)
    slides.set_ylim(0.0, 100.0)
    slides.spines[["top", "right"]].set_visible(False)
    slides.legend(fontsize=8, frameon=False, loc="lower right")
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=90)
    return file.getvalue()


def draw_tracks(axes: Axes, stage: Stage, way: str, below: float) -> None:
    """Draws the ways of both toes over the ground, `below` metres below those of the first row."""
    toes, stands = tracks_of(stage, way)
    for side in range(len(SIDES)):
        ahead, left = toes[:, side, 1], toes[:, side, 0] - below
        axes.plot(ahead, left, color="#cccccc", linewidth=0.8, zorder=1)
        axes.scatter(ahead[stands[:, side]], left[stands[:, side]], s=14, color=COLOURS[way], zorder=2)
    axes.text(toes[0, :, 1].min() - 0.1, -below, way, ha="right", va="center", fontsize=9, color=COLOURS[way])


def tracks_of(stage: Stage, way: str) -> tuple[Floats, NDArray[np.bool_]]:
    """Returns x and z of both toes [frames, 2, 2], and whether they stand [frames, 2]."""
    first, second, time = CHANGE
    ends = [joints[-1] for joints in stage.bank.roles.feet]
    if way == PLAIN:
        clips = stage.bank.clip(first), stage.bank.clip(second)
        places, standing = crossfade(stage, *clips, time, fade(BEFORE + AFTER, BEFORE))
        return places[:, ends][..., [0, 2]], standing >= 0.5
    characters = Characters(without_feet(stage) if way == PATHS else stage, RATE)
    characters.add(1, first, time=time)
    characters.lock_feet([0], way == LOCKED)
    toes, stands = [], []
    for frame in range(BEFORE + AFTER):
        if frame == BEFORE:
            characters.play([0], second, blend=FADE)
        toes.append(character_positions(characters)[0, ends][:, [0, 2]])
        stands.append(standing_feet(characters)[0] >= 0.5)
        characters.advance()
    return np.array(toes), np.array(stands)
