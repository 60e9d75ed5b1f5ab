"""Measures what standing actions cost at run time: `python -m bench.characters.standing`.

All clips of a generated bank are standing actions, which are added to the locomotion's own upper half; those of another
bank with the same motions have a gait. Splices by the evaluator and frames of characters are timed in both, in turns;
the ratio is taken within rounds. Cold: the caches are emptied before each call.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.characters.costs import crowd, frame_work
from bench.findings import Findings
from bench.generated import Size, generate
from bench.rounds import Work, evict_caches, interleaved, paired_ratio
from bench.speed.workload import Scene, evaluation, request_sets
from motionsplice.cli import run
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

COUNT = 1000


def main(
    joints: Annotated[int, typer.Option(help="Joints of the generated banks")] = 31,
    rounds: Annotated[int, typer.Option(min=2, help="Rounds of each comparison")] = 300,
) -> None:
    """Prints nanoseconds per character and frame with a gait and standing, and their ratio."""
    with tempfile.TemporaryDirectory() as folder:
        gaits, standing = (
            Evaluator(generate(Path(folder) / str(stands), Size(joints, standing=stands))) for stands in (False, True)
        )
    findings = Findings(f"{COUNT} characters of {joints} joints: nanoseconds")
    for scene in (Scene(), Scene(sequential=True)):
        gait, stood = (evaluation(one, request_sets(one.bank, COUNT, scene)) for one in (gaits, standing))
        compare(findings, f"splices, {scene.label}", gait, stood, rounds)
    gait, stood = (evaluation(one, request_sets(one.bank, COUNT, Scene())) for one in (gaits, standing))
    compare(findings, "splices, cold", gait, stood, max(rounds // 3, 2), cold=True)
    gait, stood = (frame_work(crowd(Stage(one), COUNT, 0, ())) for one in (gaits, standing))
    compare(findings, "characters", gait, stood, rounds)
    findings.show()


def compare(findings: Findings, label: str, gait: Work, standing: Work, rounds: int, *, cold: bool = False) -> None:
    """Times two pieces of work in turns, and adds their times and the ratio within rounds."""
    seconds = interleaved({"with a gait": gait, "standing": standing}, rounds, before=evict_caches if cold else None)
    for name, times in seconds.items():
        findings.add(f"{label}, {name}", 1e9 * float(np.median(times)) / COUNT, "{:.0f}")
    findings.add(f"{label}, standing / with a gait", paired_ratio(seconds["standing"], seconds["with a gait"]))


if __name__ == "__main__":
    run(lambda: typer.run(main))
