"""Checks that recorded commands, given again at the same frames, give the same bytes."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from bench.characters.aiming import random_target
from bench.characters.joint_speeds import RATE
from bench.characters.scenes import Command
from bench.findings import Findings
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

COMMANDS, ROWS = 10_000, 100
FRAMES = 2400


class Recorded(NamedTuple):
    """A command to the character in `row` at `frame`."""

    frame: int
    row: int
    command: Command


class Performance(NamedTuple):
    """The result of a performance: a digest of each frame's poses, the last state, and the half-way state as .npy."""

    digests: list[bytes]
    state: bytes
    middle: bytes


def replay(stage: Stage, commands: int = COMMANDS, frames: int = FRAMES) -> Findings:
    """Performs recorded commands twice, and once more from the half-way state on another stage of the same bank."""
    recorded = record(stage, np.random.default_rng(0), commands, frames)
    first = perform(start(stage), recorded, range(frames))
    again = perform(start(stage), recorded, range(frames))
    fresh = Stage(Evaluator(stage.bank))
    restored = Characters(fresh, RATE, np.load(io.BytesIO(first.middle)))
    rest = perform(restored, recorded, range(frames // 2, frames))
    findings = Findings(f"{len(recorded)} recorded commands to {ROWS} characters in {frames} frames")
    for label, repeated in (("replayed", again), ("replayed from the half-way state", rest)):
        digests = zip(first.digests[-len(repeated.digests) :], repeated.digests, strict=True)
        findings.add(f"{label}: frames that differ", sum(a != b for a, b in digests), "{:.0f}", most=0)
        findings.add(f"{label}: final states that differ", float(repeated.state != first.state), "{:.0f}", most=0)
    return findings


def record(stage: Stage, draw: np.random.Generator, commands: int, frames: int) -> list[Recorded]:
    """Draws random commands at random frames, in order of frames."""
    names = [clip.name for clip in stage.bank.clips]
    return [
        Recorded(frame, int(draw.integers(ROWS)), replayed_command(names, draw))
        for frame in np.sort(draw.integers(frames, size=commands)).tolist()
    ]


def replayed_command(names: list[str], draw: np.random.Generator) -> Command:
    """Draws a command: one of the scenes with targets, or one that changes speed, weight, place or root motion."""
    kind = draw.integers(12)
    if kind == 0:
        return Command("speed", (float(draw.uniform(0.7, 1.2)),), {}, frozenset())
    if kind == 1:
        return Command("weight", (float(draw.random()),), {}, frozenset())
    if kind == 2:
        return Command("place", (draw.normal(size=3).tolist(), float(draw.normal())), {}, frozenset())
    if kind == 3:
        return Command("in_place", (bool(draw.integers(2)),), {}, frozenset())
    return random_target(names, draw)


def start(stage: Stage) -> Characters:
    """Adds ROWS characters that play the first clip."""
    characters = Characters(stage, RATE)
    characters.add(ROWS, stage.bank.clips[0].name)
    return characters


def perform(characters: Characters, recorded: Iterable[Recorded], frames: range) -> Performance:
    """Gives the commands of the frames in `frames`, and evaluates each of these frames."""
    poses, digests, middle = characters.stage.evaluator.poses(len(characters)), [], io.BytesIO()
    due: dict[int, list[Recorded]] = {}
    for given in recorded:
        due.setdefault(given.frame, []).append(given)
    for frame in frames:
        if frame == frames.stop // 2:
            np.save(middle, characters.state)
        for given in due.get(frame, ()):
            given.command.give(characters, given.row)
        characters.evaluate(poses)
        digests.append(hashlib.sha256(poses.root_positions.tobytes() + poses.flat.tobytes()).digest())
        characters.advance()
    return Performance(digests, characters.state.tobytes(), middle.getvalue())
