"""What characters are like from one second to the next: `python -m bench.characters [CLIPS] [--baseline NAME]`.

pops         random commands to a character for six seconds, again and again: the fastest that any joint moves, over the
             fastest of the clips that were played.
slide        how far feet slide over the ground while all that is mixed has them stand, metres, median over stances.
masks        the right arm of an action on a person who walks otherwise: how far elbow and wrist are, from the hips, off
             the motion of the person who does both; with the arm's own rotations, and turned with its attachment.
cost         of a character and frame, in turns with a plain splice by the evaluator.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from bench.clips import bank_of
from bench.generated import Size, generate
from bench.rounds import Work, interleaved, paired_ratio
from bench.service.findings import Findings
from bench.workload import Scene, evaluation, request_sets
from motion.kinematics import hips_heading, joint_positions
from motion.procedural.library import truth
from motion.quaternion import Floats, about, rotate
from motionsplice.cli import run
from runtime import character_state as col
from runtime.bank import Bank
from runtime.character import Characters, Stage
from runtime.contacts import FEET
from runtime.evaluator import Evaluator
from runtime.requests import Poses

RATE, FRAMES = 60.0, 360
LIKELY = 0.04  # that a command comes with a frame
FOREVER = 1e6  # seconds of a fade that is held where it is


def main(
    clips: Annotated[Path | None, typer.Argument(help="A folder of clips; the built-in ones if not given")] = None,
    baseline: Annotated[str | None, typer.Option(help="The clip to align to")] = None,
    scenes: Annotated[int, typer.Option(min=1, help="Random scenes")] = 1000,
) -> None:
    """Prints what is found."""
    with tempfile.TemporaryDirectory() as folder:
        stage = Stage(Evaluator(bank_of(clips, baseline, Path(folder))))
        stage.warm()
        pops(stage, scenes).show()
        if clips is None:
            slides(stage).show()
            masks(stage).show()
            costs(Stage(Evaluator(generate(Path(folder) / "generated", Size())))).show()


def pops(stage: Stage, scenes: int) -> Findings:
    """How fast joints move over any switch, start, stop and loop."""
    fastest = {clip.name: float(speeds(clip_positions(stage, clip.name)).max()) for clip in stage.bank.clips}
    ratios = np.array([pop(stage, fastest, seed) for seed in range(scenes)])
    told = Findings(f"{scenes} random scenes of {FRAMES / RATE:g} s: fastest joint over the clips' fastest")
    told.add("median", float(np.median(ratios)))
    told.add("99th percentile", float(np.percentile(ratios, 99.0)))
    told.add("largest", float(ratios.max()), most=1.5)
    told.add("scenes above 1.5", float(np.sum(ratios > 1.5)), "{:.0f}", most=0)
    return told


def pop(stage: Stage, fastest: Mapping[str, float], seed: int) -> float:
    draw, names = np.random.default_rng(seed), list(fastest)
    characters, played = Characters(stage, RATE), {str(draw.choice(names))}
    characters.add(1, next(iter(played)))
    positions = []
    for _ in range(FRAMES):
        if draw.random() < LIKELY:
            first, second = (str(name) for name in draw.choice(names, 2, replace=False))
            blend: Any = {"blend": float(draw.uniform(0.2, 0.6))}
            kind = draw.integers(5)
            if kind == 0:
                characters.play([0], first, **blend)
            elif kind == 1:
                characters.play([0], {first: 0.5, second: 0.5}, **blend)
            elif kind == 2:
                when: Any = draw.choice(list(col.WHENS))
                characters.act([0], first, when=when, loop=bool(draw.integers(2)), blend_out=blend["blend"], **blend)
            elif kind == 3:
                mask: Any = draw.choice(list(col.MASKS))
                characters.act([0], first, mask=mask, **blend)
            else:
                characters.stop([0], **blend)
            played |= {first, second} if kind == 1 else {first} if kind < 4 else set()
        positions.append(shown(characters)[0])
        characters.advance()
    return float(speeds(np.array(positions)).max()) / max(fastest[name] for name in played)


def shown(characters: Characters) -> Floats:
    """World positions [n, J, 3] of all joints."""
    poses = characters.stage.evaluator.poses(len(characters))
    characters.evaluate(poses)
    return in_the_world(characters.stage, poses)


def clip_positions(stage: Stage, name: str) -> Floats:
    """The same [F, J, 3] of a clip by itself."""
    times = np.arange(0.0, stage.bank.clip(name).duration, 1.0 / RATE)
    return in_the_world(stage, stage.evaluator.sequence(name, times))


def in_the_world(stage: Stage, poses: Poses) -> Floats:
    positions = np.empty((len(poses.flat), stage.bank.skeleton.joint_count, 3), np.float32)
    stage.evaluator.world_positions(poses, positions)
    return positions.astype(np.float64)


def speeds(positions: Floats) -> Floats:
    """Metres a second [F - 1, J] of joints [F, J, 3]."""
    return np.asarray(np.linalg.norm(np.diff(positions, axis=0), axis=-1) * RATE)


def slides(stage: Stage) -> Findings:
    """Feet in mixes of two locomotions, against each of them alone."""
    told = Findings("A foot slides while it stands, metres (median over stances)")
    for first, second in (("walk", "run"), ("walk", "slow_walk"), ("walk", "curve"), ("slow_walk", "run")):
        found = [slide(stage, {first: 1.0 - weight, second: weight}) for weight in (0.0, 0.25, 0.5, 0.75, 1.0)]
        told.add(f"{first}, alone", found[0], "{:.3f}")
        told.add(f"{second}, alone", found[-1], "{:.3f}")
        most = max(found[0], found[-1]) + 0.01
        told.add(f"{first} and {second}, worst of three mixes", max(found[1:-1]), "{:.3f}", most=most)
    return told


def slide(stage: Stage, weights: Mapping[str, float]) -> float:
    """How far the lower joint of a foot goes over the floor in a stance."""
    characters = Characters(stage, RATE)
    characters.add(1, {name: weight for name, weight in weights.items() if weight})
    roles, ways = stage.bank.roles, []
    going: dict[str, list[Floats]] = {name: [] for name in FEET}
    for _ in range(600):
        positions, standing = shown(characters)[0], stands(stage, characters.state[0])
        for (name, bit), joints in zip(FEET.items(), roles.feet, strict=True):
            if standing & bit:
                going[name].append(positions[joints[-1], [0, 2]])
            elif going[name]:
                ways.append(float(np.linalg.norm(np.ptp(going[name], axis=0))) if len(going[name]) > 6 else np.nan)
                going[name] = []
        characters.advance()
    return float(np.nanmedian(ways))


def stands(stage: Stage, s: Floats) -> int:
    """The feet that all locomotions of a character have stand."""
    standing = 3
    for number in range(int(s[col.LOCOMOTIONS])):
        slot = s[col.FIRST_LOCOMOTION + number * col.LOCOMOTION_COLUMNS :]
        entry = stage.bank.clips[int(slot[col.CLIP])]
        standing &= int(stage.bank.tables["contacts"][entry.first_row + int(slot[col.FRAME])])
    return standing


def masks(stage: Stage) -> Findings:
    """A right arm alone, against the motion of one who does both."""
    told, bank = Findings("A right arm alone: centimetres from the truth, mean of elbow and wrist"), stage.bank
    for locomotion, action in product(("walk", "run", "side_step"), ("wave", "punch", "push", "carry_box")):
        real, roles = truth(locomotion, action), bank.roles
        arm = bank.skeleton.subtree(bank.skeleton.parents[roles.right_shoulder])
        characters = Characters(stage, RATE)
        characters.add(1, locomotion)
        characters.act([0], action, mask="right_arm", blend=0.0)
        turned, plain, wanted = [], [], []
        wanted_all = from_hips(joint_positions(real), bank)
        for frame in range(200):
            poses = stage.evaluator.poses(1)
            characters.evaluate(poses)
            turned.append(in_the_world(stage, poses)[0])
            slot = characters.state[0, col.FIRST_ACTION :]
            own = bank.motion(action, seam=True).sampled([slot[col.FRAME]])[1][0]
            poses.rotations[0, arm] = own[arm]
            plain.append(in_the_world(stage, poses)[0])
            wanted.append(wanted_all[round(frame * real.rate / RATE)])
            characters.advance()
        joints = [roles.right_elbow, roles.right_wrist]
        for label, found in (("its own rotations", plain), ("turned with its attachment", turned)):
            apart = from_hips(np.array(found), bank)[:, joints] - np.array(wanted)[:, joints]
            told.add(
                f"{action} on {locomotion}, {label}", 100.0 * float(np.linalg.norm(apart, axis=-1).mean()), "{:.1f}"
            )
    return told


def from_hips(positions: Floats, bank: Bank) -> Floats:
    """Positions [F, J, 3] as seen from the hips."""
    turn = about([0.0, 1.0, 0.0], -hips_heading(positions, bank.roles))
    return rotate(turn[:, None], positions - positions[:, :1])


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
        characters.act([row], str(draw.choice(names)), blend=0.0)
    for row in range(fading):
        for one in do:
            getattr(characters, one)([row], str(draw.choice(names)), blend=FOREVER)
    fades = characters.state[:fading]
    for column in (col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS, col.FIRST_ACTION + col.ACTION_COLUMNS):
        fades[:, column + col.ELAPSED] = 0.5 * FOREVER
    return characters


if __name__ == "__main__":
    run(lambda: typer.run(main))
