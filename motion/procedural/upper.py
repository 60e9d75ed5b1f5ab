"""The upper body as a locomotion moves it: trunk against the pelvis, arms against the legs, a steady gaze."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.procedural.body import LEFT, RIGHT, euler
from motionsplice.motion.quaternion import Floats

TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Carriage:
    """How a locomotion carries the upper body; angles in radians.

    `lean` is the trunk's mean forward pitch, `twist` and `list` the amplitudes of its turn and roll against the
    path, `nod` of its pitch twice a stride. The upper arms swing by `swing` about `hang` (forward positive), held
    off the body by `abduction` and turned inwards by `inward`; the elbows bend by `elbow`, and by `elbow_swing`
    more and less. Arms and twist are `lead` cycles ahead of a walk's, against the heel strikes. Where one carriage
    turns into another, each is an array [F].
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
        """This carriage where `weight` [F] is 0, the other where it is 1."""
        both = {field.name: (getattr(self, field.name), getattr(other, field.name)) for field in fields(self)}
        return Carriage(**{name: first + (second - first) * weight for name, (first, second) in both.items()})


@dataclass(frozen=True)
class Rhythm:
    """What the locomotion imposes on the upper body, over F frames.

    phase [F] in cycles from the left heel strike; swing [F], that of arms and twist; pace [F], the steps' length
    against full ones; headings [F] of shoulders and gaze; lean [F], the roll into a curve; time [F] in seconds.
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
    """The chest's yaw against the shoulders' heading, its pitch and its roll, each [F]."""

    yaw: Floats
    pitch: Floats
    roll: Floats


@dataclass(frozen=True)
class Arm:
    """One arm over F frames: rotations [F, 4] of upper arm, forearm and hand against the chest."""

    upper: Floats
    fore: Floats
    hand: Floats


def trunk(carriage: Carriage, rhythm: Rhythm) -> Trunk:
    """The chest turns against the pelvis, rolls to the standing leg and nods after each heel strike."""
    angle = TURN * rhythm.phase
    return Trunk(
        yaw=carriage.twist * rhythm.pace * np.cos(TURN * rhythm.swing - 0.25),
        pitch=carriage.lean + carriage.nod * rhythm.pace * np.cos(2.0 * angle - 1.3),
        roll=carriage.list * rhythm.pace * np.sin(angle + 0.2) - rhythm.lean,
    )


def hanging_arm(side: float, flexion: Floats, abduction: Floats, inward: Floats, elbow: Floats) -> Arm:
    """An arm by its joint angles [F]: hanging down at zero, with the palm to the thigh."""
    lateral = euler(0.0, -flexion, 0.0)
    outward = euler(0.0, 0.0, side * abduction)
    turned = euler(-side * inward, 0.0, np.full_like(inward, -0.5 * np.pi * side))
    # The inward turn comes after the hang, about the arm itself: yaw of a bone that points down.
    upper = quaternion.multiply(quaternion.multiply(lateral, outward), turned)
    fore = quaternion.multiply(upper, euler(-side * elbow, 0.15, 0.0))
    hand = quaternion.multiply(fore, euler(-side * 0.12, 0.0, 0.0))
    return Arm(upper, fore, hand)


def swinging_arm(carriage: Carriage, rhythm: Rhythm, side: float) -> Arm:
    """The arm's natural swing, forward with the other side's leg; the elbow bends as it comes forward."""
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
    return {side: swinging_arm(carriage, rhythm, side) for side in (LEFT, RIGHT)}
