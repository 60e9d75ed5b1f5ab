"""Measures a masked right arm against the true motion of a person who does locomotion and action together."""

from __future__ import annotations

from itertools import product

import numpy as np

from bench.characters.joint_speeds import RATE, pose_positions
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
    """Measures how far elbow and wrist of a masked right arm are from the truth, relative to the hips."""
    findings = Findings("Masked right arm: error of elbow and wrist, centimetres")
    bank = stage.bank
    for locomotion, action in product(("walk", "run", "side_step"), ("wave", "punch", "push", "carry_box")):
        true_clip, roles = truth(locomotion, action), bank.roles
        arm = bank.skeleton.subtree(bank.skeleton.parents[roles.right_shoulder])
        characters = Characters(stage, RATE)
        characters.add(1, locomotion)
        characters.act([0], Action(action, mask="right_arm", blend=0.0))
        turned, plain, true_positions = [], [], []
        all_true_positions = from_hips(joint_positions(true_clip), bank)
        for frame in range(200):
            poses = stage.evaluator.poses(1)
            characters.evaluate(poses)
            turned.append(pose_positions(stage, poses)[0])
            slot = characters.state[0, col.FIRST_ACTION :]
            own = bank.motion(action, seam=True).sampled([slot[col.FRAME]])[1][0]
            poses.rotations[0, arm] = own[arm]
            plain.append(pose_positions(stage, poses)[0])
            true_positions.append(all_true_positions[round(frame * true_clip.rate / RATE)])
            characters.advance()
        joints = [roles.right_elbow, roles.right_wrist]
        for label, positions in (("own rotations", plain), ("turned with its attachment", turned)):
            apart = from_hips(np.array(positions), bank)[:, joints] - np.array(true_positions)[:, joints]
            distance = 100.0 * float(np.linalg.norm(apart, axis=-1).mean())
            findings.add(f"{action} on {locomotion}, {label}", distance, "{:.1f}")
    return findings


def from_hips(positions: Floats, bank: Bank) -> Floats:
    """Returns positions [F, J, 3] relative to the hips, turned so that the hips face forward."""
    turn = about([0.0, 1.0, 0.0], -hips_heading(positions, bank.roles))
    return rotate(turn[:, None], positions - positions[:, :1])
