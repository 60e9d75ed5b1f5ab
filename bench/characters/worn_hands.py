"""Measures what a hands layer costs at run time: `python -m bench.characters.worn_hands`.

All clips of a generated bank have hands. Splices by the evaluator and frames of characters are timed with and without
hands, in turns; the ratio is taken within rounds. Cold: the caches are emptied before each call.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.characters.costs import COUNT, FOREVER, compare, frame_work
from bench.findings import Findings
from bench.generated import HANDS, Size, generate
from bench.rounds import Work
from bench.speed.workload import RATE, Scene, evaluation, request_sets
from motionsplice.cli import run
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Requests
from motionsplice.runtime.stage import Stage


def main(
    joints: Annotated[
        int, typer.Option(help="Joints of the generated bank; the built-in body with fingers has 52")
    ] = 52,
    rounds: Annotated[int, typer.Option(min=2, help="Rounds of each comparison")] = 300,
) -> None:
    """Prints nanoseconds per character and frame with and without hands, and their ratio."""
    with tempfile.TemporaryDirectory() as folder:
        evaluator = Evaluator(generate(Path(folder) / "bank", Size(joints, hands=True)))
    driven = len(evaluator.bank.layout.hands.joints)
    findings = Findings(f"{COUNT} characters, hands drive {driven} of {joints} joints: nanoseconds")
    for scene, cold in ((Scene(), False), (Scene(sequential=True), False), (Scene(), True)):
        work = {name: splice_work(evaluator, scene, name == "with hands") for name in ("without hands", "with hands")}
        label = "splices, cold" if cold else f"splices, {scene.label}"
        compare(findings, label, work, max(rounds // 3, 2) if cold else rounds, cold=cold)
    stage = Stage(evaluator)
    bare, wearing, fading = (frame_work(with_hands(stage, hands)) for hands in ((), (HANDS,), (HANDS, HANDS)))
    compare(findings, "characters", {"without hands": bare, "with hands": wearing}, rounds)
    compare(findings, "characters that fade", {"without hands": bare, "with hands": fading}, rounds)
    findings.show()


def splice_work(evaluator: Evaluator, scene: Scene, hands: bool) -> Work:
    """Evaluates splices of random clips, all with hands or all without."""
    sets: Sequence[Requests] = request_sets(evaluator.bank, COUNT, scene, seed=int(hands))
    for requests in sets:
        requests.hands[:] = int(hands)
    return evaluation(evaluator, sets)


def with_hands(stage: Stage, hands: Sequence[str]) -> Characters:
    """Characters with a locomotion, an action and hands layers. A second layer stays in the middle of its fade-in."""
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
