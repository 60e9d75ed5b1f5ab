"""Measures the error of interpolation between keys: `python -m bench.quality.interpolation [CLIP.bvh]`.

The truth is motion at a high rate. Every k-th frame is a key, as in a bank at a lower rate, and slerp of the keys is
compared with the frames between them. Built-in motion is generated at 960 Hz. A captured clip is judged at its own
rate, so a clip captured at 120 Hz cannot judge keys at 120 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from motionsplice.cli import run
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make

TRUE_RATE = 960.0
KEY_RATES = (30.0, 60.0, 120.0)
BUILT_IN = (("walk", None), ("run", None), ("walk", "punch"), ("turn_180", None), ("stairs_down", "wave"))


@dataclass(frozen=True)
class Loss:
    """The error of slerp of keys at `rate` Hz over all joints and frames.

    mean, p99, worst: distance of joints in the world, metres. worst_turn: angle of a joint, radians.
    """

    rate: float
    mean: float
    p99: float
    worst: float
    worst_turn: float


def main(
    clip: Annotated[Path | None, typer.Argument(help="A captured clip; default: built-in motions")] = None,
    skip_frames: Annotated[int, typer.Option(min=0, help="Leading frames to skip, such as a T-pose")] = 0,
) -> None:
    """Prints the error of interpolation for keys at 30, 60 and 120 Hz."""
    clips = (
        [read_clip(clip, skip_frames=skip_frames).clip]
        if clip
        else [make(*names, seconds=6.0, rate=TRUE_RATE) for names in BUILT_IN]
    )
    table = Table(title="Error of slerp between keys", title_justify="left")
    for column in ("clip", "truth at", "keys at", "mean mm", "p99 mm", "worst mm", "worst turn °"):
        table.add_column(column, justify="left" if column == "clip" else "right")
    for one in clips:
        for loss in losses(one):
            lengths = (f"{1e3 * metres:.3f}" for metres in (loss.mean, loss.p99, loss.worst))
            turn = f"{np.degrees(loss.worst_turn):.3f}"
            table.add_row(one.name, f"{one.rate:g} Hz", f"{loss.rate:g} Hz", *lengths, turn)
        table.add_section()
    Console(width=110).print(table)


def losses(true: Clip) -> list[Loss]:
    """Returns the loss at each of KEY_RATES that divides the clip's rate. Raises ClipError if none does."""
    steps = {rate: round(true.rate / rate) for rate in KEY_RATES}
    fit = [rate for rate, step in steps.items() if step > 1 and abs(step * rate - true.rate) < 1e-3 * true.rate]
    if not fit:
        problem = f"its rate of {true.rate:g} Hz is not a multiple of {', '.join(f'{r:g}' for r in KEY_RATES)} Hz"
        raise ClipError(problem, place=f"clip {true.name!r}", mend="Use a clip captured at 120 Hz or more")
    return [loss_of(true, steps[rate], rate) for rate in fit]


def loss_of(true: Clip, step: int, rate: float) -> Loss:
    """Returns the loss if only every `step`-th frame is a key."""
    count = (true.frame_count - 1) // step * step + 1
    true = true.frames(0, count)
    keys = replace(
        true, rate=true.rate / step, root_positions=true.root_positions[::step], rotations=true.rotations[::step]
    )
    positions, rotations = keys.sampled(np.arange(count) / step)
    between = replace(true, root_positions=positions, rotations=rotations)
    apart = np.linalg.norm(joint_positions(between) - joint_positions(true), axis=-1)
    turns = quaternion.angle(between.rotations, true.rotations)
    return Loss(rate, float(apart.mean()), float(np.percentile(apart, 99)), float(apart.max()), float(turns.max()))


if __name__ == "__main__":
    run(lambda: typer.run(main))
