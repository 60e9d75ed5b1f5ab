"""How far standing feet slide: in clips played alone and in their seams, in mixes, and in changes of locomotion.

Mixes and changes are played in three ways: roots follow the mixed paths; standing feet drive the root; feet are locked
too. Changes are also played as engines do it by default, by a plain crossfade.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations, permutations

import numpy as np

from bench.characters.crossfade import crossfade
from bench.characters.feet import Stance, stances, stances_of, without_feet
from bench.characters.joint_speeds import RATE
from bench.findings import Findings
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.format.entries import ClipEntry
from motionsplice.runtime.stage import Stage

FADE = 0.3  # seconds, as by default
PER_STRIDE = 8  # moments of a stride at which the locomotion changes
BEFORE, AFTER = 36, 40  # frames played before and after a change, so that its first and last stance are whole
SIDEWAYS = "side_step"  # its feet pass each other sideways, so other gaits cannot change to it without a slide
LONG = 900  # frames of a clip played alone, several loops of it
MIXED = 300  # frames of a mix
PATHS, DRIVEN, LOCKED = "by paths", "by standing feet", "feet locked"
PLAIN = "plain crossfade"
WAYS = (PATHS, DRIVEN, LOCKED)
NO_TARGETS: Mapping[str, float] = {}

Pair = tuple[ClipEntry, ClipEntry]


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
    summary(findings, "within the clip", alone)
    summary(findings, "in the seam", seamed, {"largest": 1.5})
    return findings


def mixes(stage: Stage) -> Findings:
    """Measures stances in mixes of two locomotions with constant weights."""
    findings = Findings("Slide of a standing foot, mixes of two, centimetres")
    for way in WAYS:
        characters = Characters(without_feet(stage) if way == PATHS else stage, RATE)
        for pair in combinations([clip.name for clip in locomotions(stage) if clip.name != SIDEWAYS], 2):
            for weight in (0.25, 0.5, 0.75):
                characters.add(1, dict(zip(pair, (1.0 - weight, weight), strict=True)))
        characters.lock_feet(slice(None), way == LOCKED)
        summary(findings, way, [one.slide for one in stances(characters, MIXED)])
    return findings


def changes(stage: Stage) -> Findings:
    """Measures stances during changes of locomotion."""
    findings = Findings(f"Slide of a standing foot, changes of locomotion in {FADE:g} s, centimetres")
    for way in (PLAIN, *WAYS):
        found, pairs = stances_of_changes(stage, way)
        beside = [SIDEWAYS in {clip.name for clip in pairs[one.character]} for one in found]
        slides = np.array([one.slide for one in found])
        targets = {"median": 1.5, "90 %": 4.0} if way == DRIVEN else NO_TARGETS
        summary(findings, way, slides[~np.array(beside)].tolist(), targets)
        if any(beside):
            summary(findings, f"{way}, to and from a side-step", slides[beside].tolist())
    return findings


def stances_of_changes(stage: Stage, way: str) -> tuple[list[Stance], list[Pair]]:
    """Returns the stances that a change of locomotion touches, and the change of each character."""
    fading = BEFORE + round(FADE * RATE)
    if way == PLAIN:
        moments = moments_of_changes(stage)
        pairs = [(first, second) for first, second, _ in moments]
        faded = [crossfade(stage, *moment, fade(fading + AFTER, BEFORE)) for moment in moments]
        positions, standing = (np.stack(one, axis=1) for one in zip(*faded, strict=True))
        found = stances_of(stage, positions, standing)
    else:
        characters, pairs = before_changes(without_feet(stage) if way == PATHS else stage)
        characters.lock_feet(slice(None), way == LOCKED)

        def change(frame: int) -> None:
            if frame == BEFORE:
                begin_changes(characters, pairs)

        found = stances(characters, fading + AFTER, change)
    return [one for one in found if one.first < fading - 1 and one.end > BEFORE + 1], pairs  # two frames of it or more


def before_changes(stage: Stage) -> tuple[Characters, list[Pair]]:
    """Returns characters that play a locomotion, and which change to which: every ordered pair, PER_STRIDE of each.

    They begin at moments spread over a stride.
    """
    characters, pairs = Characters(stage, RATE), list[Pair]()
    for first, second, time in moments_of_changes(stage):
        characters.add(1, first.name, time=time)
        pairs.append((first, second))
    return characters, pairs


def moments_of_changes(stage: Stage) -> list[tuple[ClipEntry, ClipEntry, float]]:
    """Returns clip, next clip, and the seconds into the first at which each character begins."""
    return [
        (first, second, moment / PER_STRIDE * first.duration / max(first.cycles, 1.0))
        for first, second in permutations(locomotions(stage), 2)
        for moment in range(PER_STRIDE)
    ]


def fade(frames: int, begins: int) -> Floats:
    """Returns the share [frames] of what fades in from a frame on within FADE seconds, as characters fade."""
    risen = np.clip((np.arange(frames) - begins) / (FADE * RATE), 0.0, 1.0)
    return np.asarray(risen * risen * (3.0 - 2.0 * risen))


def begin_changes(characters: Characters, pairs: Sequence[Pair]) -> None:
    """Begins the change of each character."""
    for row, (_, second) in enumerate(pairs):
        characters.play([row], second.name, blend=FADE)


def locomotions(stage: Stage) -> list[ClipEntry]:
    """Returns the bank's locomotions with a gait."""
    return [clip for clip in stage.bank.clips if clip.gait and clip.kind == "locomotion"]


def summary(findings: Findings, label: str, slides: Sequence[float], most: Mapping[str, float] = NO_TARGETS) -> None:
    """Adds the distribution of slides in metres as centimetres; `most` are targets of its numbers, by name."""
    for name, share in (("median", 50.0), ("90 %", 90.0), ("largest", 100.0)):
        value = 100.0 * float(np.percentile(slides, share))
        findings.add(f"{label} ({len(slides)} stances): {name}", value, "{:.1f}", most=most.get(name))
