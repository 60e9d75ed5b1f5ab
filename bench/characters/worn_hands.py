"""What hands over a body cost at run time: `python -m bench.characters.worn_hands`.

A generated bank whose clips all have hands; requests to the evaluator, and characters, with and without them, in turns,
and the paired ratio. Cold: before each call more memory is written than the caches hold.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.characters.costs import FOREVER, played
from bench.findings import Findings
from bench.generated import HANDS, Size, generate
from bench.rounds import Work, evict_caches, interleaved, paired_ratio
from bench.speed.workload import RATE, Scene, evaluation, request_sets
from motionsplice.cli import run
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Requests
from motionsplice.runtime.stage import Stage

COUNT = 1000


def main(
    joints: Annotated[int, typer.Option(help="Of the generated bank; the built-in body has 52 with its fingers")] = 52,
    rounds: Annotated[int, typer.Option(min=2)] = 300,
) -> None:
    """Prints nanoseconds of a character and frame, and how many times as long as without hands."""
    with tempfile.TemporaryDirectory() as folder:
        evaluator = Evaluator(generate(Path(folder) / "bank", Size(joints, hands=True)))
    driven = len(evaluator.bank.layout.hands.joints)
    told = Findings(f"{COUNT} characters of {joints} joints, of which hands drive {driven}: nanoseconds")
    for scene in (Scene(), Scene(sequential=True)):
        plain, worn = (asked(evaluator, scene, hands) for hands in (False, True))
        compare(told, f"splices, {scene.label}", plain, worn, rounds)
    plain, worn = (asked(evaluator, Scene(), hands) for hands in (False, True))
    compare(told, "splices, cold", plain, worn, max(rounds // 3, 2), cold=True)
    stage = Stage(evaluator)
    bare, wearing, fading = (played(dressed(stage, hands)) for hands in ((), (HANDS,), (HANDS, HANDS)))
    compare(told, "characters", bare, wearing, rounds)
    compare(told, "characters whose hands are faded into others", bare, fading, rounds)
    told.show()


def compare(told: Findings, label: str, plain: Work, worn: Work, rounds: int, *, cold: bool = False) -> None:
    """Adds the times of two pieces of work that are taken in turns, and the ratio within rounds."""
    seconds = interleaved({"without": plain, "with": worn}, rounds, before=evict_caches if cold else None)
    for name, one in seconds.items():
        told.add(f"{label}, {name} hands", 1e9 * float(np.median(one)) / COUNT, "{:.0f}")
    told.add(f"{label}, with over without", paired_ratio(seconds["with"], seconds["without"]))


def asked(evaluator: Evaluator, scene: Scene, hands: bool) -> Work:
    """Splices of any clips, each with hands or none."""
    sets: Sequence[Requests] = request_sets(evaluator.bank, COUNT, scene, seed=int(hands))
    for requests in sets:
        requests.hands[:] = int(hands)
    return evaluation(evaluator, sets)


def dressed(stage: Stage, hands: Sequence[str]) -> Characters:
    """Characters that act over a locomotion, and wear hands, the last of which are half faded in for ever."""
    draw, characters = np.random.default_rng(len(hands)), Characters(stage, RATE)
    names = [clip.name for clip in stage.bank.clips]
    characters.add(COUNT, names[0])
    for row in range(COUNT):
        characters.play([row], str(draw.choice(names)), blend=0.0)
        characters.act([row], Action(str(draw.choice(names)), blend=0.0))
    for number, name in enumerate(hands):
        characters.wear(range(COUNT), name, blend=FOREVER if number else 0.0)
    return characters


if __name__ == "__main__":
    run(lambda: typer.run(main))
