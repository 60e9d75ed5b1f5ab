"""Whether recorded commands, given again at the same frames, give the same bytes."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from bench.characters.joint_speeds import RATE
from bench.characters.scenes import Command, drawn
from bench.findings import Findings
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

COMMANDS, ROWS = 10_000, 100
FRAMES = 2400


class Recorded(NamedTuple):
    frame: int
    row: int
    command: Command


class Taken(NamedTuple):
    """What came of a performance: each frame's poses as a digest, the last state, and that of its middle as a file."""

    digests: list[bytes]
    state: bytes
    middle: bytes


def replay(stage: Stage, commands: int = COMMANDS, frames: int = FRAMES) -> Findings:
    """Records commands, and performs them: again, and from the middle on with another stage of the same bank."""
    recorded = record(stage, np.random.default_rng(0), commands, frames)
    first = perform(begun(stage), recorded, range(frames))
    again = perform(begun(stage), recorded, range(frames))
    fresh = Stage(Evaluator(stage.bank))
    restored = Characters(fresh, RATE, np.load(io.BytesIO(first.middle)))
    rest = perform(restored, recorded, range(frames // 2, frames))
    told = Findings(f"{len(recorded)} recorded commands to {ROWS} characters in {frames} frames")
    for label, one in (("given again", again), ("given to a copy from the middle on", rest)):
        digests = zip(first.digests[-len(one.digests) :], one.digests, strict=True)
        told.add(f"{label}: frames that differ", sum(a != b for a, b in digests), "{:.0f}", most=0)
        told.add("states that differ", float(one.state != first.state), "{:.0f}", most=0)
    return told


def record(stage: Stage, draw: np.random.Generator, commands: int, frames: int) -> list[Recorded]:
    """Commands of any kind at any frames, in order."""
    names = [clip.name for clip in stage.bank.clips]
    return [
        Recorded(frame, int(draw.integers(ROWS)), any_command(names, draw))
        for frame in np.sort(draw.integers(frames, size=commands)).tolist()
    ]


def any_command(names: list[str], draw: np.random.Generator) -> Command:
    """Those of random scenes, and those that change how what is played goes on."""
    kind = draw.integers(12)
    if kind == 0:
        return Command("speed", (float(draw.uniform(0.7, 1.2)),), {}, frozenset())
    if kind == 1:
        return Command("weight", (float(draw.random()),), {}, frozenset())
    if kind == 2:
        return Command("place", (draw.normal(size=3).tolist(), float(draw.normal())), {}, frozenset())
    if kind == 3:
        return Command("in_place", (bool(draw.integers(2)),), {}, frozenset())
    return drawn(names, draw)


def begun(stage: Stage) -> Characters:
    characters = Characters(stage, RATE)
    characters.add(ROWS, stage.bank.clips[0].name)
    return characters


def perform(characters: Characters, recorded: Iterable[Recorded], frames: range) -> Taken:
    """Gives the commands of some frames, and shows these."""
    poses, digests, middle = characters.stage.evaluator.poses(len(characters)), [], io.BytesIO()
    due: dict[int, list[Recorded]] = {}
    for one in recorded:
        due.setdefault(one.frame, []).append(one)
    for frame in frames:
        if frame == frames.stop // 2:
            np.save(middle, characters.state)
        for one in due.get(frame, ()):
            one.command.give(characters, one.row)
        characters.evaluate(poses)
        digests.append(hashlib.sha256(poses.root_positions.tobytes() + poses.flat.tobytes()).digest())
        characters.advance()
    return Taken(digests, characters.state.tobytes(), middle.getvalue())
