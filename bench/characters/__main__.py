"""Measures characters over time: `python -m bench.characters [CLIPS] [--baseline NAME]`.

pops         A character receives random commands for six seconds, in many scenes. How fast does the fastest joint move,
             relative to the fastest joint of the clips played, and of the same playback without transitions?
phases       While one locomotion blends into another, how far apart are their phases?
replay       Do 10,000 recorded commands give the same bytes a second time, and after a restore half-way?
slide        How far does a standing foot slide over the ground in one stance: while clips play and loop, in mixes of
             two, and when a locomotion changes to another? Roots follow the mixed paths, or standing feet drive them,
             or feet are locked too. Changes also by a plain crossfade, as engines do it by default. Centimetres.
knees        How fast is the fastest knee while a locomotion changes and feet are locked? And pops, with feet locked.
masks        An action's right arm is played on another walk. How far are elbow and wrist, relative to the hips, from
             the motion of a person who does both? With the arm's own rotations, and turned with its attachment.
cost         What does a frame of a character cost, next to a plain splice by the evaluator?

With CLIPS, the last two do not run.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from bench.characters.costs import costs
from bench.characters.gaits import phases
from bench.characters.knees import knees
from bench.characters.masks import masks
from bench.characters.replay import replay
from bench.characters.scenes import pops
from bench.characters.slides import changes, loops, mixes
from bench.clips import bank_of
from bench.generated import Size, generate
from motionsplice.cli import run
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: the built-in motions")] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Clip that all others are aligned to; default: chosen automatically")
    ] = None,
    scenes: Annotated[int, typer.Option(min=1, help="Number of random scenes")] = 1000,
) -> None:
    """Prints how smooth, repeatable and fast characters are."""
    with tempfile.TemporaryDirectory() as folder:
        stage = Stage(Evaluator(bank_of(clips, baseline, Path(folder))))
        Characters.warm(stage)
        pops(stage, scenes).show()
        phases(stage).show()
        replay(stage).show()
        for measure in (loops, mixes, changes, knees):
            measure(stage).show()
        pops(stage, scenes, locked=True).show()
        if clips is None:
            masks(stage).show()
            costs(Stage(Evaluator(generate(Path(folder) / "generated", Size())))).show()


if __name__ == "__main__":
    run(lambda: typer.run(main))
