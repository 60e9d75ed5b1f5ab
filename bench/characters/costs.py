"""The cost of a character's frame, inside and outside transitions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bench.characters.joint_speeds import RATE
from bench.findings import Findings
from bench.rounds import Work, evict_caches, interleaved, paired_ratio
from bench.speed.workload import Scene, evaluation, request_sets
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.stage import Stage

COUNT = 1000  # characters
FOREVER = 1e6  # seconds: a fade this long stays where it is during the measurement


def costs(stage: Stage) -> Findings:
    """Times one frame of a character, evaluated and advanced, outside and in the middle of transitions.

    A steady character plays a splice without a transition. All are compared with splices by the evaluator, at random
    and at sequential times. Sequential times advance by a frame per round, as a character's do, so that their rows are
    in the caches.
    """
    count = COUNT
    work: dict[str, Work] = {
        name: evaluation(stage.evaluator, request_sets(stage.bank, count, Scene(sequential=sequential)))
        for name, sequential in (("evaluator", False), ("evaluator, sequential times", True))
    }
    locked = crowd(stage, count, 0, ())
    locked.lock_feet(slice(None))
    work["steady character, feet locked"] = frame_work(locked)
    walking = crowd(stage, count, 0, ())
    walking.stop(slice(None), blend=0.0)
    walking.advance()
    work["no action"] = frame_work(walking)
    transitions = {"fading locomotions": ("play",), "fading actions": ("act",), "fading both": ("play", "act")}
    for name, fading in {"steady character": (), **transitions}.items():
        work[name] = frame_work(crowd(stage, count, count if fading else 0, fading))
    parts: dict[str, dict[str, Any]] = {"weight 0.5": {"weight": 0.5}, "right arm": {"mask": "right_arm"}}
    for name, settings in parts.items():
        work[name] = frame_work(crowd(stage, count, 0, (), **settings))
    seconds = interleaved(work, 100)
    findings = Findings(f"{count} characters of a generated bank: nanoseconds")
    for name, times in seconds.items():
        findings.add(name, 1e9 * float(np.median(times)) / count, "{:.0f}")
    findings.add(
        "steady character / evaluator", paired_ratio(seconds["steady character"], seconds["evaluator"]), most=1.3
    )
    findings.add(
        "feet locked / steady character",
        paired_ratio(seconds["steady character, feet locked"], seconds["steady character"]),
    )
    for name in transitions:
        most = 2.2 if name != "fading both" else None
        for other, wanted in (("evaluator", most), ("evaluator, sequential times", None), ("steady character", None)):
            findings.add(f"{name} / {other}", paired_ratio(seconds[name], seconds[other]), most=wanted)
    for name, wanted in (("no action", None), ("weight 0.5", None), ("right arm", 2.0)):
        findings.add(f"{name} / evaluator", paired_ratio(seconds[name], seconds["evaluator"]), most=wanted)
        findings.add(f"{name} / steady character", paired_ratio(seconds[name], seconds["steady character"]))
    many = {part: frame_work(crowd(stage, 10_000, part, ("play", "act"))) for part in (0, 100)}
    seconds = interleaved({str(part): run for part, run in many.items()}, 40)
    findings.add("10,000 characters: 1 % in transition / none", paired_ratio(seconds["100"], seconds["0"]), most=1.15)
    return findings


def compare(findings: Findings, label: str, work: Mapping[str, Work], rounds: int, *, cold: bool = False) -> None:
    """Times two pieces of work on COUNT characters in turns; adds their times, and the second's over the first's."""
    seconds = interleaved(work, rounds, before=evict_caches if cold else None)
    for name, times in seconds.items():
        findings.add(f"{label}, {name}", 1e9 * float(np.median(times)) / COUNT, "{:.0f}")
    first, second = work
    findings.add(f"{label}, {second} / {first}", paired_ratio(seconds[second], seconds[first]))


def frame_work(characters: Characters) -> Work:
    """Evaluates and advances characters by a frame."""
    poses = characters.stage.evaluator.poses(len(characters))

    def frame(_: int) -> None:
        characters.evaluate(poses)
        characters.advance()

    return frame


def crowd(stage: Stage, count: int, fading: int, do: tuple[str, ...], **settings: Any) -> Characters:
    """Characters that play random pairs, with `settings` of the action.

    The first `fading` of them stay in the middle of transitions.
    """
    draw, characters = np.random.default_rng(0), Characters(stage, RATE)
    names = [clip.name for clip in stage.bank.clips]
    for name in names:
        characters.add(count // len(names), name)
    duration = stage.bank.clips[0].duration
    for row in range(len(characters)):
        characters.play([row], str(draw.choice(names)), time=draw.random() * duration, blend=0.0)
        characters.act([row], Action(str(draw.choice(names)), blend=0.0, **settings))
    for row in range(fading):
        if "play" in do:
            characters.play([row], str(draw.choice(names)), blend=FOREVER)
        if "act" in do:
            characters.act([row], Action(str(draw.choice(names)), blend=FOREVER))
    fades = characters.state[:fading]
    for column in (col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS, col.FIRST_ACTION + col.ACTION_COLUMNS):
        fades[:, column + col.ELAPSED] = 0.5 * FOREVER
    return characters
