"""What a character and frame costs, in transition and out of it."""

from __future__ import annotations

import numpy as np

from bench.characters.joint_speeds import RATE
from bench.findings import Findings
from bench.rounds import Work, interleaved, paired_ratio
from bench.speed.workload import Scene, evaluation, request_sets
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.stage import Stage

FOREVER = 1e6  # seconds of a fade that is held where it is


def costs(stage: Stage) -> Findings:
    """A character's frame, evaluated and advanced: playing, and in the middle of transitions; beside the evaluator's
    splices at any times, and at times that go on by a frame, as a character's do, so that rows are in the caches."""
    count = 1000
    work: dict[str, Work] = {
        name: evaluation(stage.evaluator, request_sets(stage.bank, count, Scene(sequential=going_on)))
        for name, going_on in (("evaluator", False), ("evaluator, times that go on", True))
    }
    transitions = {"locomotions": ("play",), "actions": ("act",), "both": ("play", "act")}
    for name, fading in {"a splice": (), **transitions}.items():
        work[name] = played(crowd(stage, count, count if fading else 0, fading))
    seconds = interleaved(work, 100)
    told = Findings(f"{count} characters of a generated bank, nanoseconds a character and frame")
    for name, one in seconds.items():
        told.add(name, 1e9 * float(np.median(one)) / count, "{:.0f}")
    told.add("a splice as character, over the evaluator", paired_ratio(seconds["a splice"], seconds["evaluator"]))
    for name in transitions:
        most = 2.2 if name != "both" else None
        for other, wanted in (("evaluator", most), ("evaluator, times that go on", None), ("a splice", None)):
            told.add(f"{name} over {other}", paired_ratio(seconds[name], seconds[other]), most=wanted)
    many = {part: played(crowd(stage, 10_000, part, ("play", "act"))) for part in (0, 100)}
    seconds = interleaved({str(part): one for part, one in many.items()}, 40)
    told.add("10,000, 1 % in transition, over none", paired_ratio(seconds["100"], seconds["0"]), most=1.15)
    return told


def played(characters: Characters) -> Work:
    poses = characters.stage.evaluator.poses(len(characters))

    def frame(_: int) -> None:
        characters.evaluate(poses)
        characters.advance()

    return frame


def crowd(stage: Stage, count: int, fading: int, do: tuple[str, ...]) -> Characters:
    """Characters of any pair, the first of them for ever in transition."""
    draw, characters = np.random.default_rng(0), Characters(stage, RATE)
    names = [clip.name for clip in stage.bank.clips]
    for name in names:
        characters.add(count // len(names), name)
    last = stage.bank.clips[0].duration
    for row in range(len(characters)):
        characters.play([row], str(draw.choice(names)), time=draw.random() * last, blend=0.0)
        characters.act([row], Action(str(draw.choice(names)), blend=0.0))
    for row in range(fading):
        if "play" in do:
            characters.play([row], str(draw.choice(names)), blend=FOREVER)
        if "act" in do:
            characters.act([row], Action(str(draw.choice(names)), blend=FOREVER))
    fades = characters.state[:fading]
    for column in (col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS, col.FIRST_ACTION + col.ACTION_COLUMNS):
        fades[:, column + col.ELAPSED] = 0.5 * FOREVER
    return characters
