"""How far standing feet slide: in clips played alone and in their seams, in mixes, and in changes of locomotion.

A foot stands while the locomotions in which it has contact hold at least half of the shares. It rolls from heel to toe,
so in each frame the joint that moves least is taken as the one that stands. The slide of a stance is the extent of the
way that this joint goes over the ground.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations, permutations
from typing import NamedTuple

import numpy as np

from bench.characters.joint_speeds import RATE, character_positions
from bench.characters.steady import LEGS
from bench.findings import Findings
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.format.contacts import FEET
from motionsplice.runtime.format.manifest import ClipEntry
from motionsplice.runtime.stage import Stage

FADE = 0.3  # seconds, as by default
PER_STRIDE = 8  # moments of a stride at which the locomotion changes
BEFORE, AFTER = 36, 40  # frames played before and after a change, so that its first and last stance are whole
BRIEF = 6  # frames: stances of at most so many do not count
SIDEWAYS = "side_step"  # its feet pass each other sideways, so other gaits cannot change to it without a slide
NO_TARGETS: Mapping[str, float] = {}
LONG = 900  # frames of a clip played alone, several loops of it
MIXED = 300  # frames of a mix


class Stance(NamedTuple):
    """A stance: number of the character, its first frame and the frame after its last, and its slide in metres."""

    character: int
    first: int
    end: int
    slide: float


def loops(stage: Stage) -> Findings:
    """Measures stances of locomotions that play alone, apart for those that touch a seam."""
    characters, clips, seam = Characters(stage, RATE), locomotions(stage), []
    for clip in clips:
        characters.add(1, clip.name)

    def note(_: int) -> None:
        seam.append(characters.state[:, col.FIRST_LOCOMOTION + col.FRAME] >= [clip.frame_count - 1 for clip in clips])

    alone, seamed = list[float](), list[float]()
    for one in stances(characters, LONG, note):
        in_seam = np.array(seam)[one.first : one.end, one.character].any()
        (seamed if in_seam else alone).append(one.slide)
    findings = Findings("Slide of a standing foot, one clip alone, centimetres")
    summary(findings, "stances within the clip", alone)
    summary(findings, "stances in the seam", seamed, {"largest": 1.5})
    return findings


def mixes(stage: Stage) -> Findings:
    """Measures stances in mixes of two locomotions with constant weights."""
    characters = Characters(stage, RATE)
    for first, second in combinations(forward(stage), 2):
        for weight in (0.25, 0.5, 0.75):
            characters.add(1, {first.name: 1.0 - weight, second.name: weight})
    findings = Findings("Slide of a standing foot, mixes of two, centimetres")
    summary(findings, "all mixes", [one.slide for one in stances(characters, MIXED)])
    return findings


def changes(stage: Stage, *, locked: bool = False) -> Findings:
    """Measures stances during changes of locomotion, with the foot lock on or off."""
    characters, pairs = before_changes(stage)
    characters.lock_feet(slice(None), locked)

    def change(frame: int) -> None:
        if frame == BEFORE:
            begin_changes(characters, pairs)

    fading = BEFORE + round(FADE * RATE)
    found = [
        one
        for one in stances(characters, fading + AFTER, change)
        if one.first < fading - 1 and one.end > BEFORE + 1  # at least two frames of it are in the change
    ]
    lock = ", feet locked" if locked else ""
    findings = Findings(f"Slide of a standing foot, changes of locomotion in {FADE:g} s{lock}, centimetres")
    sideways = [SIDEWAYS in {clip.name for clip in pairs[one.character]} for one in found]
    ahead = [one.slide for one, is_sideways in zip(found, sideways, strict=True) if not is_sideways]
    label = "changes" if not any(sideways) else "changes but to and from a side-step"
    summary(findings, label, ahead, {"median": 1.5, "90 %": 4.0})
    if any(sideways):
        beside = [one.slide for one, is_sideways in zip(found, sideways, strict=True) if is_sideways]
        summary(findings, "changes to and from a side-step", beside)
    return findings


def before_changes(stage: Stage) -> tuple[Characters, list[tuple[ClipEntry, ClipEntry]]]:
    """Returns characters that play a locomotion, and which change to which: every ordered pair, PER_STRIDE of each.

    They begin at moments spread over a stride.
    """
    characters, pairs = Characters(stage, RATE), list[tuple[ClipEntry, ClipEntry]]()
    for first, second in permutations(locomotions(stage), 2):
        stride = first.duration / max(first.cycles, 1.0)
        for moment in range(PER_STRIDE):
            characters.add(1, first.name, time=moment / PER_STRIDE * stride)
            pairs.append((first, second))
    return characters, pairs


def begin_changes(characters: Characters, pairs: Sequence[tuple[ClipEntry, ClipEntry]]) -> None:
    """Begins the change of each character."""
    for row, (_, second) in enumerate(pairs):
        characters.play([row], second.name, blend=FADE)


def locomotions(stage: Stage) -> list[ClipEntry]:
    """Returns the bank's locomotions with a gait."""
    return [clip for clip in stage.bank.clips if clip.gait and clip.kind == "locomotion"]


def forward(stage: Stage) -> list[ClipEntry]:
    """Returns the locomotions but the side-step."""
    return [clip for clip in locomotions(stage) if clip.name != SIDEWAYS]


def summary(findings: Findings, label: str, slides: Sequence[float], most: Mapping[str, float] = NO_TARGETS) -> None:
    """Adds the distribution of slides in metres as centimetres; `most` are targets of its numbers, by name."""
    for name, share in (("median", 50.0), ("90 %", 90.0), ("largest", 100.0)):
        value = 100.0 * float(np.percentile(slides, share))
        findings.add(f"{len(slides)} {label}: {name}", value, "{:.1f}", most=most.get(name))


def stances(characters: Characters, frames: int, before: Callable[[int], None] = lambda _: None) -> Iterator[Stance]:
    """Plays `frames` frames, and yields all stances that begin and end in them.

    Calls `before` with the number of each frame before it is evaluated.
    """
    feet = np.array(characters.stage.bank.roles.feet)
    positions, standing = [], []
    for frame in range(frames):
        before(frame)
        positions.append(character_positions(characters)[:, feet][..., [0, 2]])
        standing.append(standing_feet(characters) >= 0.5)
        characters.advance()
    moves = np.diff(np.array(positions), axis=0)  # [frames - 1, n, 2 feet, joints, 2]
    least = np.linalg.norm(moves, axis=-1).argmin(axis=-1)
    steps = np.take_along_axis(moves, least[..., None, None], axis=3)[:, :, :, 0]
    stands = np.array(standing).astype(np.int8)
    for foot in range(len(FEET)):
        for character in range(len(characters)):
            edges = np.flatnonzero(np.diff(stands[:, character, foot])) + 1
            if stands[0, character, foot]:
                edges = edges[1:]  # it began before the first frame
            for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=False):
                if end - first > BRIEF:
                    way = np.cumsum(steps[first : end - 1, character, foot], axis=0)
                    extent = np.maximum(way.max(axis=0), 0.0) - np.minimum(way.min(axis=0), 0.0)
                    yield Stance(character, first, end, float(np.linalg.norm(extent)))


def standing_feet(characters: Characters) -> Floats:
    """Returns the shares [n, 2] of the locomotions in which the left and the right foot stand."""
    state, bank = characters.state, characters.stage.bank
    first_rows = np.array([clip.first_row for clip in bank.clips])
    found = np.zeros((len(state), len(FEET)))
    for number, slot in enumerate(LEGS):
        used = number < state[:, col.LOCOMOTIONS]
        row = first_rows[state[:, slot + col.CLIP].astype(np.int64)] + state[:, slot + col.FRAME].astype(np.int64)
        bits = bank.tables["contacts"][np.where(used, row, 0)]
        share = np.where(used, state[:, slot + col.SHARE], 0.0)
        found += share[:, None] * np.stack([bits & bit > 0 for bit in FEET.values()], axis=1)
    return found
