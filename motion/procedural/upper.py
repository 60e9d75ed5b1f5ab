"""The upper body in locomotion: the trunk turns against the pelvis, the arms swing against the legs."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.procedural.body import LEFT, RIGHT, euler
from motionsplice.motion.quaternion import Floats

TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Carriage:
    """The upper body's parameters in a locomotion; angles in radians. In a blend of two carriages each is an array [F].

    lean:        mean forward pitch of the trunk.
    twist, list: amplitudes of the trunk's yaw and roll relative to the path.
    nod:         amplitude of the trunk's pitch, which oscillates twice a stride.
    swing, hang: amplitude and mean of the upper arms' swing, forward positive.
    abduction, inward: how far the upper arms are held off the body and turned inwards.
    elbow, elbow_swing: mean and amplitude of the elbows' bend.
    lead:        cycles by which arms and twist are ahead of a walk's, relative to the heel strikes.
    """

    lean: float | Floats
    twist: float | Floats
    list: float | Floats
    nod: float | Floats
    swing: float | Floats
    hang: float | Floats
    abduction: float | Floats
    inward: float | Floats
    elbow: float | Floats
    elbow_swing: float | Floats
    lead: float | Floats = 0.0

    def turning_to(self, other: Carriage, weight: Floats) -> Carriage:
        """Returns the blend of this carriage, at `weight` [F] 0, and the other, at weight 1."""
        both = {field.name: (getattr(self, field.name), getattr(other, field.name)) for field in fields(self)}
        return Carriage(**{name: first + (second - first) * weight for name, (first, second) in both.items()})


@dataclass(frozen=True)
class Rhythm:
    """The locomotion's inputs to the upper body, each [F].

    phase: cycles from the left heel strike.
    swing: the phase of arms and twist.
    pace:  length of the steps relative to full steps.
    shoulders, gaze: headings, radians about Y.
    lean:  roll into a curve, radians.
    time:  seconds.
    """

    phase: Floats
    swing: Floats
    pace: Floats
    shoulders: Floats
    gaze: Floats
    lean: Floats
    time: Floats


@dataclass(frozen=True)
class Trunk:
    """The chest's yaw relative to the shoulders' heading, its pitch and its roll, each [F], radians.

    glance, nod: how far the head turns to the left, and down, on purpose.
    """

    yaw: Floats
    pitch: Floats
    roll: Floats
    glance: float | Floats = 0.0
    nod: float | Floats = 0.0


@dataclass(frozen=True)
class Arm:
    """An arm over F frames: rotations [F, 4] of upper arm, forearm and hand relative to the chest."""

    upper: Floats
    fore: Floats
    hand: Floats


def trunk(carriage: Carriage, rhythm: Rhythm) -> Trunk:
    """Returns the trunk: it turns against the pelvis, rolls to the standing leg and nods after each heel strike."""
    angle = TURN * rhythm.phase
    return Trunk(
        yaw=carriage.twist * rhythm.pace * np.cos(TURN * rhythm.swing - 0.25),
        pitch=carriage.lean + carriage.nod * rhythm.pace * np.cos(2.0 * angle - 1.3),
        roll=carriage.list * rhythm.pace * np.sin(angle + 0.2) - rhythm.lean,
    )


def hanging_arm(side: float, flexion: Floats, abduction: Floats, inward: Floats, elbow: Floats) -> Arm:
    """Returns an arm by its joint angles [F], radians. At zero it hangs down, with the palm to the thigh."""
    lateral = euler(0.0, -flexion, 0.0)
    outward = euler(0.0, 0.0, side * abduction)
    turned = euler(-side * inward, 0.0, np.full_like(inward, -0.5 * np.pi * side))
    # The arm is rolled from the T-pose to hang down, then turned inwards about its own axis, which is now vertical.
    upper = quaternion.multiply(quaternion.multiply(lateral, outward), turned)
    fore = quaternion.multiply(upper, euler(-side * elbow, 0.15, 0.0))
    hand = quaternion.multiply(fore, euler(-side * 0.12, 0.0, 0.0))
    return Arm(upper, fore, hand)


def swinging_arm(carriage: Carriage, rhythm: Rhythm, side: float) -> Arm:
    """Returns an arm in natural swing: forward with the other side's leg, the elbow bending on the way forward."""
    angle = TURN * rhythm.swing + (np.pi if side == LEFT else 0.0)
    wave = np.cos(angle - 0.2) + 0.08 * np.cos(2.0 * angle - 0.6)
    late = np.cos(angle - 0.75)
    pace = rhythm.pace
    return hanging_arm(
        side,
        flexion=carriage.hang + carriage.swing * pace * wave,
        abduction=carriage.abduction - 0.02 * pace * wave,
        inward=carriage.inward * (0.6 + 0.4 * late),
        elbow=carriage.elbow + carriage.elbow_swing * pace * late,
    )


def swinging_arms(carriage: Carriage, rhythm: Rhythm) -> dict[float, Arm]:
    """Returns both arms in natural swing, by side."""
    return {side: swinging_arm(carriage, rhythm, side) for side in (LEFT, RIGHT)}
