"""How fast knees turn while the locomotion changes and feet are locked, next to the same without the lock."""

from __future__ import annotations

import numpy as np

from bench.characters.joint_speeds import RATE
from bench.characters.slides import AFTER, BEFORE, FADE, before_changes, begin_changes, locomotions
from bench.findings import Findings
from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.stage import Stage

ALONE = 300  # frames of each clip alone
MOST = 1.2  # allowed speed of a knee as a multiple of the fastest of the clips and of the same change without the lock


def knees(stage: Stage) -> Findings:
    """Measures the fastest knee of each change of locomotion, with the foot lock and without it."""
    alone = Characters(stage, RATE)
    for clip in locomotions(stage):
        alone.add(1, clip.name)
    names = [clip.name for clip in locomotions(stage)]
    of_clip = dict(zip(names, fastest_knees(alone, ALONE).tolist(), strict=True))
    fastest = []
    for locked in (False, True):
        characters, pairs = before_changes(stage)
        characters.lock_feet(slice(None), locked)
        before = fastest_knees(characters, BEFORE)
        begin_changes(characters, pairs)
        fastest.append(np.maximum(before, fastest_knees(characters, round(FADE * RATE) + AFTER)))
    clips = np.array([max(of_clip[first.name], of_clip[second.name]) for first, second in pairs])
    findings = Findings(f"{len(pairs)} changes of locomotion: speed of the fastest knee")
    for label, speeds, reference in (
        ("not locked / clips alone", fastest[0], clips),
        ("locked / clips alone", fastest[1], clips),
        ("locked / larger of clips and not locked", fastest[1], np.maximum(clips, fastest[0])),
    ):
        ratios = speeds / reference
        findings.add(f"{label}: median", float(np.median(ratios)))
        findings.add(f"{label}: 99 %", float(np.percentile(ratios, 99.0)))
        findings.add(f"{label}: largest", float(ratios.max()), most=MOST if "larger" in label else None)
    return findings


def fastest_knees(characters: Characters, frames: int) -> Floats:
    """Plays frames, and returns the speed [n] of each character's faster knee, radians per second."""
    roles, before, fastest = characters.stage.bank.roles, None, np.zeros(len(characters))
    poses = characters.stage.evaluator.poses(len(characters))
    for _ in range(frames):
        characters.evaluate(poses)
        now = poses.rotations[:, [roles.left_knee, roles.right_knee]].astype(np.float64)
        if before is not None:
            np.maximum(fastest, RATE * quaternion.angle(before, now).max(axis=1), out=fastest)
        before = now
        characters.advance()
    return fastest
