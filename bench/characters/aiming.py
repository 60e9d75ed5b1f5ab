"""Measures where characters that look and aim point: `python -m bench.characters.aiming [CLIPS] [--baseline NAME]`.

gaze    Where does the head look, relative to straight ahead, when nobody tells it, and relative to a point that it is
        to look at? Degrees, over all pairs with an action. Frames in which the point lies outside the limits, or in
        which the turn to it has not settled, do not count. Beside it, engines' additive aim offset toward the point,
        laid on naive replacement and on the splice.
hands   By how much do both hands, seen from the hips, swing from side to side? The standard deviation of their yaw from
        the heading; with an aim or an aim offset, from its direction. How far does the line from shoulder to wrist
        point past the point of an aimed arm?
near    How far past a point at a given distance do head and arms point, while the chest aims at it, too?
pops    Random scenes as in `python -m bench.characters`, in which characters also look and aim.
cost    What does a frame of a character cost with targets, next to one without?
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from bench.characters.aim_offset import offset
from bench.characters.aimed import (
    AHEAD,
    FRAMES,
    UP,
    WITHIN,
    Shown,
    Tell,
    degrees_apart,
    gazes,
    is_within,
    nothing,
    of_motion,
    shown,
    swivel,
    yaws,
)
from bench.characters.costs import crowd, frame_work
from bench.characters.joint_speeds import RATE
from bench.characters.scenes import MOST, Command, add_ratios, fastest_of_scenes, random_command
from bench.clips import bank_of
from bench.findings import Findings
from bench.generated import Size, generate
from bench.rounds import interleaved
from motionsplice.cli import run
from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import common_ancestor
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.aim import AIM_PARTS, Aim, Look
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

ASIDE = (2.0, 1.6, 9.0)  # the point to look at, metres


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: the built-in motions")] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Clip that all others are aligned to; default: chosen automatically")
    ] = None,
    scenes: Annotated[int, typer.Option(min=1, help="Number of random scenes")] = 300,
) -> None:
    """Prints where characters point, how smoothly they get there, and what it costs."""
    with tempfile.TemporaryDirectory() as folder:
        stage = Stage(Evaluator(bank_of(clips, baseline, Path(folder))))
        gaze(stage).show()
        hands(stage).show()
        near(stage).show()
        pops(stage, scenes).show()
        if clips is None:
            costs(Stage(Evaluator(generate(Path(folder) / "generated", Size())))).show()


def names(stage: Stage, kind: str) -> list[str]:
    """Returns the names of the clips of a kind that have a gait."""
    return [clip.name for clip in stage.bank.clips if clip.kind == kind and clip.gait]


def gaze(stage: Stage) -> Findings:
    """Measures where heads look on every locomotion, mean and largest of all actions."""
    findings, head = Findings("Where the head looks, degrees"), stage.bank.roles.head
    for locomotion in names(stage, "locomotion"):
        for form in ("naive", "splice"):
            apart, additive = [], list[Floats]()
            for action in names(stage, "action"):
                clip = shown(stage, locomotion, action, nothing, form)
                ahead = quaternion.rotate(quaternion.about(UP, clip.headings), AHEAD)
                apart.append(degrees_apart(gazes(stage, clip), ahead))
                turned = offset(stage, clip, head, ASIDE - clip.places[:, head])
                to = ASIDE - turned.places[:, head]
                additive.append(degrees_apart(gazes(stage, turned), to)[is_within(turned, to)])
            findings.add(f"{locomotion}: {form}, from straight ahead: mean", float(np.mean(apart)))
            add_misses(findings, f"{locomotion}: {form} with an aim offset, from the point", additive)
        apart = []
        for action in names(stage, "action"):
            clip = shown(stage, locomotion, action, lambda one: one.look([0], Look(ASIDE)))
            to = ASIDE - clip.places[:, head]
            apart.append(degrees_apart(gazes(stage, clip), to)[is_within(clip, to)])
        add_misses(findings, f"{locomotion}: look, from the point", apart, most=1.0)
    return findings


def add_misses(findings: Findings, label: str, apart: Sequence[Floats], most: float | None = None) -> None:
    """Adds mean, 99th percentile and the largest of angles in all frames that count, if there are any."""
    angles = np.concatenate(apart)
    if len(angles):
        findings.add(f"{label}: mean", float(angles.mean()))
        findings.add(f"{label}: 99th percentile", float(np.percentile(angles, 99.0)), most=most)
        findings.add(f"{label}: largest", float(angles.max()))


def hands(stage: Stage) -> Findings:
    """Measures the swivel of hands, for actions that hold both in front, and where single arms point."""
    findings, roles, actions = Findings("Hands, degrees"), stage.bank.roles, in_front(stage)
    chest = common_ancestor(stage.bank.skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    to = np.broadcast_to(AHEAD, (FRAMES, 3))
    for locomotion in names(stage, "locomotion") if actions else ():
        for form in ("naive", "splice"):
            clips = [shown(stage, locomotion, action, nothing, form) for action in actions]
            found = [swivel(stage, clip) for clip in clips]
            findings.add(f"{locomotion}: swivel of {', '.join(actions)}, {form}: mean", float(np.mean(found)))
            found = [swivel(stage, offset(stage, clip, chest, to), aimed=True) for clip in clips]
            findings.add(f"{locomotion}: the same with an aim offset, {form}: mean", float(np.mean(found)))
        for steady, most in ((0.0, None), (1.0, 1.5)):
            clips = [shown(stage, locomotion, action, ahead_of(steady)) for action in actions]
            found = [swivel(stage, clip, aimed=True) for clip in clips]
            findings.add(f"{locomotion}: the same, aim, steady={steady:g}: mean", float(np.mean(found)))
            findings.add(f"{locomotion}: the same, aim, steady={steady:g}: largest", max(found), most=most)
    for locomotion in names(stage, "locomotion"):
        apart = []
        for action in names(stage, "action"):
            clip = shown(stage, locomotion, action, right_arm_aside)
            shoulder, wrist = clip.places[:, roles.right_shoulder], clip.places[:, roles.right_wrist]
            within = is_within(clip, ASIDE - shoulder)
            apart.append(degrees_apart(wrist - shoulder, ASIDE - shoulder)[within])
        add_misses(findings, f"{locomotion}: right arm, from the point", apart, most=1.0)
    return findings


def right_arm_aside(characters: Characters) -> None:
    characters.aim([0], Aim(ASIDE, part="right_arm"))


def ahead_of(steady: float) -> Tell:
    """Aims straight ahead of where the character faces at first."""
    return lambda one: one.aim([0], Aim(direction=AHEAD, steady=steady), blend=0.0)


def in_front(stage: Stage) -> list[str]:
    """Returns the actions that hold both hands in front of the body: within 60 degrees of straight ahead."""
    clips = {action: shown(stage, action, action, nothing) for action in names(stage, "action")}
    return [action for action, clip in clips.items() if np.abs(yaws(stage, clip)).max() < WITHIN]


def near(stage: Stage) -> Findings:
    """Measures how far past near points head and arms point, at moments of a walk."""
    findings, roles = Findings("Near points, from head and arms: degrees"), stage.bank.roles
    ends = {"head": roles.head, "left_arm": roles.left_shoulder, "right_arm": roles.right_shoulder}
    for distance in (0.3, 0.5, 1.0, 3.0):
        apart = []
        for moment in range(0, 120, 12):
            for yaw in np.radians([-50.0, -20.0, 0.0, 30.0, 55.0]):
                for part, joint in ends.items():
                    characters = Characters(stage, RATE)
                    characters.add(1, stage.bank.baseline.clip)
                    characters.advance(moment)
                    characters.in_place([0])
                    characters.place([0], (0.0, 0.0, 0.0))
                    start = still(characters).places[0, joint]
                    point = start + distance * np.array([np.sin(yaw), 0.2, np.cos(yaw)])
                    characters.aim([0], Aim(point), blend=0.0)
                    if part == "head":
                        characters.look([0], Look(point), blend=0.0)
                    else:
                        characters.aim([0], Aim(point, part=part, max_yaw=2.0), blend=0.0)  # type: ignore[arg-type]
                    apart.append(miss(stage, still(characters), part, point))
        findings.add(f"{distance:g} m: largest", max(apart), most=1.0)
    return findings


def still(characters: Characters) -> Shown:
    """Returns the pose of the first character."""
    poses = characters.stage.evaluator.poses(1)
    characters.evaluate(poses)
    roots, rotations = poses.root_positions.astype(np.float64), poses.rotations.astype(np.float64)
    return of_motion(characters.stage, roots, rotations, np.zeros(1))


def miss(stage: Stage, clip: Shown, part: str, point: Floats) -> float:
    """Returns by how much a head or an arm points past a point, degrees."""
    roles = stage.bank.roles
    if part == "head":
        return float(degrees_apart(gazes(stage, clip)[0], point - clip.places[0, roles.head]))
    shoulder = clip.places[0, getattr(roles, part.replace("arm", "shoulder"))]
    wrist = clip.places[0, getattr(roles, part.replace("arm", "wrist"))]
    return float(degrees_apart(wrist - shoulder, point - shoulder))


def pops(stage: Stage, scenes: int) -> Findings:
    """Measures how fast joints move in random scenes with targets and feet locked.

    A joint that jumps changes its velocity between two frames by as much as it moves in one.
    """
    findings = Findings(f"{scenes} random scenes with targets and feet locked: speed of the fastest joint")
    fastest = fastest_of_scenes(stage, range(scenes), random_target, locked=True)
    add_ratios(findings, fastest)
    jumps = fastest.jump / np.maximum(fastest.clips, fastest.steady_jump)
    findings.add("velocity jump / larger of clips' speed and steady jump: largest", float(jumps.max()), most=MOST)
    return findings


def random_target(clips: Sequence[str], draw: np.random.Generator) -> Command:
    """Draws a command that looks or aims, or any other of the random scenes."""
    if draw.integers(2):
        return random_command(clips, draw)
    blend, kind = float(draw.uniform(0.5, 1.0)), draw.integers(4)
    to: Any = (draw.normal(size=3) * [4.0, 0.5, 4.0] + [0.0, 1.4, 6.0]).tolist()
    if kind == 0:
        return Command(str(draw.choice(["look", "aim"])), (None,), {"blend": blend}, frozenset())
    if kind == 1:
        return Command("look", (Look(to, steady=float(draw.random())),), {"blend": blend}, frozenset())
    part: Any = str(draw.choice(AIM_PARTS))
    return Command("aim", (Aim(to, part=part, steady=float(draw.integers(2))),), {"blend": blend}, frozenset())


def costs(stage: Stage) -> Findings:
    """Times one frame of a character with targets and without; the difference is taken within rounds."""
    count = 1000
    told: dict[str, Tell] = {
        "without targets": nothing,
        "look": lambda one: one.look(slice(None), Look(direction=(1.0, 0.2, 2.0)), blend=0.0),
        "look at a point": lambda one: one.look(slice(None), Look((40.0, 1.6, 60.0)), blend=0.0),
        "aim the chest": lambda one: one.aim(slice(None), Aim((40.0, 1.6, 60.0)), blend=0.0),
        "aim the chest, steady": lambda one: one.aim(slice(None), Aim((40.0, 1.6, 60.0), steady=1.0), blend=0.0),
        "aim an arm": lambda one: one.aim(slice(None), Aim((40.0, 1.6, 60.0), part="left_arm"), blend=0.0),
    }
    work = {}
    for name, tell in told.items():
        characters = crowd(stage, count, 0, ())
        tell(characters)
        work[name] = frame_work(characters)
    seconds = interleaved(work, 100)
    findings = Findings(f"{count} characters of a generated bank: nanoseconds")
    plain = seconds["without targets"]
    findings.add("without targets", 1e9 * float(np.median(plain)) / count, "{:.0f}")
    for name in list(told)[1:]:
        findings.add(f"{name}, more", 1e9 * float(np.median(seconds[name] - plain)) / count, "{:.0f}")
    return findings


if __name__ == "__main__":
    run(lambda: typer.run(main))
