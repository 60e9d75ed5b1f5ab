"""What characters are like from one second to the next: `python -m bench.characters [CLIPS] [--baseline NAME]`.

pops         random commands to a character for six seconds, again and again: the fastest that any joint moves, over the
             fastest of the clips that were played, and of the same played without transitions.
phases       of both locomotions, while one goes over into the other: how far they are out of step.
replay       10,000 commands, given again: whether the same bytes come of it, also after a restore in the middle.
slide        how far feet slide over the ground while all that is mixed has them stand, metres, median over stances.
masks        the right arm of an action on a person who walks otherwise: how far elbow and wrist are, from the hips, off
             the motion of the person who does both; with the arm's own rotations, and turned with its attachment.
cost         of a character and frame, in turns with a plain splice by the evaluator.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from bench.characters.costs import costs
from bench.characters.gaits import phases, slides
from bench.characters.masks import masks
from bench.characters.replay import replay
from bench.characters.scenes import pops
from bench.clips import bank_of
from bench.generated import Size, generate
from motionsplice.cli import run
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage


def main(
    clips: Annotated[Path | None, typer.Argument(help="A folder of clips; the built-in ones if not given")] = None,
    baseline: Annotated[str | None, typer.Option(help="The clip to align to")] = None,
    scenes: Annotated[int, typer.Option(min=1, help="Random scenes")] = 1000,
) -> None:
    """Prints what is found."""
    with tempfile.TemporaryDirectory() as folder:
        stage = Stage(Evaluator(bank_of(clips, baseline, Path(folder))))
        Characters.warm(stage)
        pops(stage, scenes).show()
        phases(stage).show()
        replay(stage).show()
        if clips is None:
            slides(stage).show()
            masks(stage).show()
            costs(Stage(Evaluator(generate(Path(folder) / "generated", Size())))).show()


if __name__ == "__main__":
    run(lambda: typer.run(main))
