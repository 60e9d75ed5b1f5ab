"""Measures how smooth characters are after 30 days of play: `python -m bench.characters.thirty_days [--days N]`.

One character walks on, one walks in a curve, and one waves over a mix of walk and run. Each frame is advanced by
itself, 60 a second. In the first and in the last hour, every joint's change of velocity from frame to frame is
measured: as a client sees it that adds the origins, and as one that has positions in the world. 30 days take about ten
minutes.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.clips import bank_of
from bench.findings import Findings
from motionsplice.cli import run
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

RATE = 60.0
HOUR = 3600 * 60  # frames
NAMES = ("walk", "curve", "wave over walk and run")
WORSE = 1.01  # of the first hour's roughness


def begin(stage: Stage) -> Characters:
    """Returns the characters of NAMES."""
    characters = Characters(stage, RATE)
    characters.add(1, "walk")
    characters.add(1, "curve")
    characters.add(1, {"walk": 1.0, "run": 1.0})
    characters.act([2], Action("wave"))
    return characters


def hour(characters: Characters, frames: int = HOUR) -> Floats:
    """Advances by an hour. Returns the rms change of velocity [2, n], metres: with origins, and without."""
    evaluator, sums = characters.stage.evaluator, np.zeros((2, len(characters)))
    poses = evaluator.poses(len(characters))
    joints = np.empty((len(characters), characters.stage.bank.skeleton.joint_count, 3), np.float32)
    seen: list[list[Floats]] = [[], []]
    for _ in range(frames):
        for rebased, places in zip((True, False), seen, strict=True):
            characters.rebase(slice(None), rebased)
            characters.evaluate(poses)
            evaluator.world_positions(poses, joints)
            places.append(joints + characters.origins[:, None])
        for total, places in zip(sums, seen, strict=True):
            if len(places) == 3:
                total += np.square(places[2] - 2.0 * places[1] + places[0]).sum(axis=2).mean(axis=1)
                del places[0]
        characters.advance()
    return np.asarray(np.sqrt(sums / (frames - 2)))


def thirty_days(stage: Stage, days: float) -> Findings:
    """Plays for some days, at least two hours."""
    characters = begin(stage)
    first = hour(characters)
    for _ in range(round(24.0 * days - 2.0) * HOUR):
        characters.advance()
    last = hour(characters)
    findings = Findings(f"Roughness of the last hour of {days:g} days, relative to the first hour")
    far = np.hypot(characters.state[:, col.PLACE], characters.state[:, col.PLACE + 2])
    for number, name in enumerate(NAMES):
        findings.add(f"{name}: distance, km", far[number] / 1000.0, "{:,.0f}")
        findings.add(f"{name}: with origins", last[0, number] / first[0, number], "{:.4f}", most=WORSE)
        findings.add(f"{name}: positions in the world", last[1, number] / first[1, number], "{:.1f}")
    return findings


def main(days: Annotated[float, typer.Option(min=0.125, help="Days of play")] = 30.0) -> None:
    """Prints how smooth the last hour is."""
    with tempfile.TemporaryDirectory() as folder:
        thirty_days(Stage(Evaluator(bank_of(None, "walk", Path(folder)))), days).show()


if __name__ == "__main__":
    run(lambda: typer.run(main))
