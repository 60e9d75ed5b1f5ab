"""Random scenes: characters receive commands for six seconds, and the speed of their joints is measured.

A pop is a joint that moves faster than it should. Three references say how fast it should move at most: the clips
played, each alone; the same playback held steady, without transitions; and plain cross-fades. The second is needed
because a splice can move joints faster than either of its clips: it speeds an action up to keep it in phase with
the legs, without any transition. The third, because a command can ask a hand to cross a metre in a fifth of a second.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from bench.characters.commanded_fades import cross_fades, fastest_of_fades
from bench.characters.joint_speeds import RATE, Watch, character_positions, fastest_of_clip
from bench.characters.steady import play_on, slot_contents, steady_rows
from bench.findings import Findings
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.stage import Stage

FRAMES = 360
LIKELY = 0.04  # probability of a command in a frame
TOGETHER = 100  # scenes played at the same time
MOST = 1.5  # allowed speed as a multiple of the reference


Draw = Callable[[Sequence[str], np.random.Generator], "Command"]


class Fastest(NamedTuple):
    """The fastest joint of each scene [n], metres per second: as played, in its clips alone, played steadily, in fades.

    jump and steady_jump: the largest change of a joint's velocity between two frames, as played and played steadily.
    """

    played: Floats
    clips: Floats
    steady: Floats
    fades: Floats
    jump: Floats
    steady_jump: Floats


def pops(stage: Stage, scenes: int, *, locked: bool = False) -> Findings:
    """Measures how fast joints move in random scenes with switches, starts, stops and loops; with feet `locked` or not.

    References are never locked.
    """
    feet = ", feet locked" if locked else ""
    findings = Findings(f"{scenes} random scenes of {FRAMES / RATE:g} s{feet}: speed of the fastest joint")
    add_ratios(findings, fastest_of_scenes(stage, range(scenes), random_command, locked=locked))
    return findings


def add_ratios(findings: Findings, fastest: Fastest) -> None:
    """Adds the speeds of scenes, relative to those of their clips, of steady playback and of cross-fades."""
    larger = np.maximum(fastest.clips, fastest.steady)
    largest = np.maximum(larger, fastest.fades)
    for label, ratios in (
        ("speed / clips alone", fastest.played / fastest.clips),
        ("speed / steady playback", fastest.played / fastest.steady),
        ("speed / larger of both", fastest.played / larger),
        ("speed / largest of all, cross-fades too", fastest.played / largest),
    ):
        findings.add(f"{label}: median", float(np.median(ratios)))
        findings.add(f"{label}: 99th percentile", float(np.percentile(ratios, 99.0)))
        findings.add(f"{label}: largest", float(ratios.max()), most=MOST)
        findings.add(f"{label}: scenes above {MOST}", float(np.sum(ratios > MOST)), "{:.0f}", most=0)
    findings.add("largest velocity jump / larger of both", float((fastest.jump / larger).max()))
    findings.add(
        "largest velocity jump in steady playback / larger of both", float((fastest.steady_jump / larger).max())
    )


def fastest_of_scenes(stage: Stage, seeds: Sequence[int], draw_command: Draw, *, locked: bool = False) -> Fastest:
    """Plays one random scene per seed."""
    fastest = {clip.name: fastest_of_clip(stage, clip.name) for clip in stage.bank.clips}
    parts = [
        play_together(stage, fastest, seeds[first : first + TOGETHER], draw_command, locked=locked)
        for first in range(0, len(seeds), TOGETHER)
    ]
    return Fastest(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def play_together(
    stage: Stage, fastest: dict[str, float], seeds: Sequence[int], draw_command: Draw, *, locked: bool
) -> Fastest:
    """Plays scenes at the same time. `fastest` has the speed of the fastest joint of each clip alone."""
    draws, names = [np.random.default_rng(seed) for seed in seeds], list(fastest)
    characters, watch, clips = Characters(stage, RATE), Watch(len(seeds)), []
    for draw in draws:
        clips.append({str(draw.choice(names))})
        characters.add(1, *clips[-1])
    characters.lock_feet(slice(None), locked)
    before = np.zeros_like(slot_contents(characters.state))
    rows, scenes, fades, scenes_of_fades = [], [], [], []
    for _ in range(FRAMES):
        for row, draw in enumerate(draws):
            if draw.random() < LIKELY:
                command = draw_command(names, draw)
                command.give(characters, row)
                clips[row] |= command.clips
        now = slot_contents(characters.state)
        for row in np.flatnonzero((now != before).any(axis=1)).tolist():
            new_rows = list(steady_rows(characters.state[row]))
            rows += new_rows
            scenes += [row] * len(new_rows)
            new_fades = list(cross_fades(characters.state[row]))
            fades += new_fades
            scenes_of_fades += [row] * len(new_fades)
        before = now
        watch.add(character_positions(characters))
        characters.advance()
    steady, steady_jump = np.zeros((2, len(seeds)))
    for most, of_rows in zip((steady, steady_jump), play_on(stage, rows), strict=True):
        np.maximum.at(most, scenes, of_rows)
    faded = np.zeros(len(seeds))
    np.maximum.at(faded, scenes_of_fades, fastest_of_fades(stage, fades))
    of_clips = np.array([max(fastest[name] for name in names_played) for names_played in clips])
    return Fastest(watch.speed, of_clips, steady, faded, watch.jump, steady_jump)


class Command(NamedTuple):
    """A method of Characters, its arguments after the rows, and the clips that it plays."""

    method: str
    arguments: tuple[Any, ...]
    options: dict[str, Any]
    clips: frozenset[str]

    def give(self, characters: Characters, row: int) -> None:
        getattr(characters, self.method)([row], *self.arguments, **self.options)


def random_command(names: Sequence[str], draw: np.random.Generator) -> Command:
    """Draws a command that plays, acts or stops."""
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
