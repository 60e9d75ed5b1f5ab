"""Measures standing actions at run time: `python -m bench.characters.standing`.

pops         Random scenes as in `python -m bench.characters`, with the built-in standing actions on all locomotions,
             then with a person's clips that stand and walk by turns.
cost         What do they cost?

For the costs, all clips of a generated bank are standing actions, which are added to the locomotion's own upper half;
those of another bank with the same motions have a gait. Splices by the evaluator and frames of characters are timed in
both, in turns; the ratio is taken within rounds. Cold: the caches are emptied before each call.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from bench.characters.costs import COUNT, compare, crowd, frame_work
from bench.characters.scenes import pops
from bench.findings import Findings
from bench.generated import Size, generate
from bench.speed.workload import Scene, evaluation, request_sets
from bench.standing.__main__ import standing_bank
from bench.standing.hybrids import Person
from motionsplice.cli import run
from motionsplice.motion.procedural.stances import STANDING, Performer
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage


def main(
    joints: Annotated[int, typer.Option(help="Joints of the generated banks")] = 31,
    rounds: Annotated[int, typer.Option(min=2, help="Rounds of each comparison")] = 300,
    scenes: Annotated[int, typer.Option(min=1, help="Number of random scenes")] = 1000,
) -> None:
    """Prints how fast joints move, nanoseconds per character and frame with a gait and standing, and their ratio."""
    with tempfile.TemporaryDirectory() as folder:
        bank = standing_bank(Path(folder), {name: Performer() for name in STANDING}, 1)
        pops(Stage(Evaluator(bank)), scenes).show()
        hybrids = Path(folder) / "hybrids"
        hybrids.mkdir()
        pops(Stage(Person(hybrids, 1).evaluator), scenes).show()
        evaluators = {
            name: Evaluator(generate(Path(folder) / name, Size(joints, standing=name == "standing")))
            for name in ("with a gait", "standing")
        }
    findings = Findings(f"{COUNT} characters of {joints} joints: nanoseconds")
    for scene, cold in ((Scene(), False), (Scene(sequential=True), False), (Scene(), True)):
        work = {name: evaluation(one, request_sets(one.bank, COUNT, scene)) for name, one in evaluators.items()}
        label = "splices, cold" if cold else f"splices, {scene.label}"
        compare(findings, label, work, max(rounds // 3, 2) if cold else rounds, cold=cold)
    crowds = {name: frame_work(crowd(Stage(one), COUNT, 0, ())) for name, one in evaluators.items()}
    compare(findings, "characters", crowds, rounds)
    findings.show()


if __name__ == "__main__":
    run(lambda: typer.run(main))
