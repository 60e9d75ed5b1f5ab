"""What characters are like from one second to the next: `python -m bench.characters [CLIPS] [--baseline NAME]`.

pops         random commands to a character for six seconds, again and again: the fastest that any joint moves, over the
             fastest of the clips that were played, and of the same played without transitions.
phases       of both locomotions, while one goes over into the other: how far they are out of step.
replay       10,000 commands, given again: whether the same bytes come of it, also after a restore in the middle.
slide        how far feet slide over the ground while all that is mixed has them stand, metres, median over stances.
masks        the right arm of an action on a person who walks otherwise: how far elbow and wrist are, from the hips, off
             the motion of the person who does both; with the arm's own rotations, and turned with its attachment.
cost         of a character and frame, in turns with a plain splice by the evaluator.
"""

from __future__ import annotations

import tempfile
from itertools import product
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.characters.gaits import phases, slides
from bench.characters.joint_speeds import RATE, in_the_world
from bench.characters.replay import replay
from bench.characters.scenes import pops
from bench.clips import bank_of
from bench.findings import Findings
from bench.generated import Size, generate
from bench.rounds import Work, interleaved, paired_ratio
from bench.speed.workload import Scene, evaluation, request_sets
from motionsplice.cli import run
from motionsplice.motion.kinematics import hips_heading, joint_positions
from motionsplice.motion.procedural.library import truth
from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

FOREVER = 1e6  # seconds of a fade that is held where it is


def main(
    clips: Annotated[Path | None, typer.Argument(help="A folder of clips; the built-in ones if not given")] = None,
    baseline: Annotated[str | None, typer.Option(help="The clip to align to")] = None,
    scenes: Annotated[int, typer.Option(min=1, help="Random scenes")] = 1000,
) -> None:
    """Prints what is found."""
    with tempfile.TemporaryDirectory() as folder:
        stage = Stage(Evaluator(bank_of(clips, baseline, Path(folder))))
        Characters.warm(stage)
        pops(stage, scenes).show()
        phases(stage).show()
        replay(stage).show()
        if clips is None:
            slides(stage).show()
            masks(stage).show()
            costs(Stage(Evaluator(generate(Path(folder) / "generated", Size())))).show()


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
