"""Random scenes: commands to characters for six seconds, and how fast joints move meanwhile.

A pop is a joint that moves faster than it should, and what it should is told in two ways: by the clips that were
played, each by itself; and by the same played steadily. For a splice moves joints faster than either of its clips where
legs in step hurry an action, and no transition is to blame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from bench.characters.joint_speeds import RATE, Watch, fastest_of_clip, shown
from bench.characters.steady import played_on, steadily, what_is_played
from bench.findings import Findings
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.stage import Stage

FRAMES = 360
LIKELY = 0.04  # that a command comes with a frame
TOGETHER = 100  # scenes at once
MOST = 1.5  # times the fastest


class Fastest(NamedTuple):
    """Metres a second of the fastest joint of each scene [n]: as it was played, in the clips of it, and steadily; and
    by how much a joint's velocity changes at most from one frame to the next, as it was played and steadily."""

    played: Floats
    clips: Floats
    steady: Floats
    jump: Floats
    steady_jump: Floats


def pops(stage: Stage, scenes: int) -> Findings:
    """How fast joints move over any switch, start, stop and loop."""
    found = fastest_of_scenes(stage, range(scenes))
    larger = np.maximum(found.clips, found.steady)
    told = Findings(f"{scenes} random scenes of {FRAMES / RATE:g} s: the fastest joint")
    for label, ratios in (
        ("over the fastest of the clips", found.played / found.clips),
        ("over the fastest of the same played steadily", found.played / found.steady),
        ("over the larger of both", found.played / larger),
    ):
        told.add(f"{label}: median", float(np.median(ratios)))
        told.add(f"{label}: 99th percentile", float(np.percentile(ratios, 99.0)))
        told.add(f"{label}: largest", float(ratios.max()), most=MOST)
        told.add(f"{label}: scenes above {MOST}", float(np.sum(ratios > MOST)), "{:.0f}", most=0)
    told.add("largest jump of a velocity in a frame, over the larger of both", float((found.jump / larger).max()))
    told.add("the same played steadily", float((found.steady_jump / larger).max()))
    return told


def fastest_of_scenes(stage: Stage, seeds: Sequence[int]) -> Fastest:
    """Plays a scene for each seed."""
    fastest = {clip.name: fastest_of_clip(stage, clip.name) for clip in stage.bank.clips}
    parts = [
        played_together(stage, fastest, seeds[first : first + TOGETHER]) for first in range(0, len(seeds), TOGETHER)
    ]
    return Fastest(*(np.concatenate(one) for one in zip(*parts, strict=True)))


def played_together(stage: Stage, fastest: dict[str, float], seeds: Sequence[int]) -> Fastest:
    draws, names = [np.random.default_rng(seed) for seed in seeds], list(fastest)
    characters, watch, clips = Characters(stage, RATE), Watch(len(seeds)), []
    for draw in draws:
        clips.append({str(draw.choice(names))})
        characters.add(1, *clips[-1])
    before = np.zeros_like(what_is_played(characters.state))
    rows, scenes = [], []
    for _ in range(FRAMES):
        for row, draw in enumerate(draws):
            if draw.random() < LIKELY:
                given = drawn(names, draw)
                given.give(characters, row)
                clips[row] |= given.clips
        now = what_is_played(characters.state)
        for row in np.flatnonzero((now != before).any(axis=1)).tolist():
            steady_rows = list(steadily(characters.state[row]))
            rows += steady_rows
            scenes += [row] * len(steady_rows)
        before = now
        watch.see(shown(characters))
        characters.advance()
    steady, steady_jump = np.zeros((2, len(seeds)))
    for most, of_rows in zip((steady, steady_jump), played_on(stage, rows), strict=True):
        np.maximum.at(most, scenes, of_rows)
    of_clips = np.array([max(fastest[name] for name in one) for one in clips])
    return Fastest(watch.speed, of_clips, steady, watch.jump, steady_jump)


class Command(NamedTuple):
    """A method of Characters, what it is given after the rows, and the clips that are played by it."""

    method: str
    arguments: tuple[Any, ...]
    options: dict[str, Any]
    clips: frozenset[str]

    def give(self, characters: Characters, row: int) -> None:
        getattr(characters, self.method)([row], *self.arguments, **self.options)


def drawn(names: Sequence[str], draw: np.random.Generator) -> Command:
    """Any command."""
    first, second = (str(name) for name in draw.choice(names, 2, replace=False))
    blend = float(draw.uniform(0.2, 0.6))
    kind = draw.integers(5)
    if kind == 0:
        return Command("play", (first,), {"blend": blend}, frozenset([first]))
    if kind == 1:
        return Command("play", ({first: 0.5, second: 0.5},), {"blend": blend}, frozenset([first, second]))
    if kind == 2:
        when: Any = str(draw.choice(list(col.WHENS)))
        action = Action(first, when=when, loop=bool(draw.integers(2)), blend=blend, blend_out=blend)
        return Command("act", (action,), {}, frozenset([first]))
    if kind == 3:
        mask: Any = str(draw.choice(list(col.MASKS)))
        return Command("act", (Action(first, mask=mask, blend=blend),), {}, frozenset([first]))
    return Command("stop", (), {"blend": blend}, frozenset())
