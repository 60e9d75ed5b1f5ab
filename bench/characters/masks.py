"""A right arm alone, against the motion of one who does both."""

from __future__ import annotations

from itertools import product

import numpy as np

from bench.characters.joint_speeds import RATE, in_the_world
from bench.findings import Findings
from motionsplice.motion.kinematics import hips_heading, joint_positions
from motionsplice.motion.procedural.library import truth
from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.stage import Stage


def masks(stage: Stage) -> Findings:
    """A right arm alone, against the motion of one who does both."""
    told, bank = Findings("A right arm alone: centimetres from the truth, mean of elbow and wrist"), stage.bank
    for locomotion, action in product(("walk", "run", "side_step"), ("wave", "punch", "push", "carry_box")):
        real, roles = truth(locomotion, action), bank.roles
        arm = bank.skeleton.subtree(bank.skeleton.parents[roles.right_shoulder])
        characters = Characters(stage, RATE)
        characters.add(1, locomotion)
        characters.act([0], Action(action, mask="right_arm", blend=0.0))
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
