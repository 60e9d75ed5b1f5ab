"""The built-in actions: motions of the upper body, performed on top of any built-in locomotion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.procedural.body import FOREARM, LEFT, RIGHT, SKELETON, UPPER_ARM, euler, frame, two_bones
from motionsplice.motion.procedural.path import ease
from motionsplice.motion.procedural.upper import Arm, Carriage, Rhythm, Trunk, swinging_arm, trunk
from motionsplice.motion.quaternion import Floats

Upper = tuple[Trunk, dict[float, Arm]]
Action = Callable[[Carriage, Rhythm, np.random.Generator], Upper]

_SHOULDER = SKELETON.offsets[SKELETON.index("LeftShoulder")] + SKELETON.offsets[SKELETON.index("LeftArm")]


def reaching_arm(
    side: float,
    wrist: Floats,
    elbow: tuple[float, float, float],
    *,
    pronation: float | Floats = 0.0,
    extension: float | Floats = 0.0,
) -> Arm:
    """Returns the arm whose wrist is at `wrist` [F, 3]: metres outward, up and forward of the shoulder, in chest axes.

    `elbow` is the direction of the elbow, also outward, up and forward. `pronation` and `extension` are in radians [F].
    At zero pronation the palm of a forearm held forward faces inwards; at a quarter turn it faces down. `extension`
    bends the hand back.
    """
    mirror = np.array([side, 1.0, 1.0])
    limb = two_bones(wrist * mirror, np.broadcast_to(np.array(elbow) * mirror, wrist.shape), UPPER_ARM, FOREARM)
    upper = frame(side * limb.upper, -side * limb.hinge)
    fore = quaternion.multiply(frame(side * limb.lower, -side * limb.hinge), euler(0.0, pronation, 0.0))
    return Arm(upper, fore, quaternion.multiply(fore, euler(0.0, 0.0, side * np.asarray(extension))))


def _still(point: tuple[float, float, float], rhythm: Rhythm, bob: float = 0.0) -> Floats:
    """Returns a held point [F, 3] that moves up and down by `bob` metres with each step."""
    held = np.tile(point, (len(rhythm.phase), 1))
    held[:, 1] += bob * rhythm.pace * np.cos(4.0 * np.pi * (rhythm.phase - 0.12))
    return held


def _carry_box(carriage: Carriage, rhythm: Rhythm, random: np.random.Generator) -> Upper:
    """Leans back under a heavy box, held by its sides in front of the body."""
    width, low, ahead = 0.19 * random.uniform(0.93, 1.07), random.uniform(-0.38, -0.35), random.uniform(0.33, 0.36)
    held = trunk(replace(carriage, twist=0.5 * carriage.twist), rhythm)
    held = replace(held, pitch=held.pitch - np.radians(random.uniform(15.5, 17.0)))
    wrist = _still((width - _SHOULDER[0], low, ahead), rhythm, bob=-0.008)
    arms = {
        side: reaching_arm(side, wrist, (0.45, -1.0, -0.5), pronation=-0.25, extension=-0.1) for side in (LEFT, RIGHT)
    }
    return held, arms


def _carry_cup(carriage: Carriage, rhythm: Rhythm, random: np.random.Generator) -> Upper:
    """Holds a cup on a level right forearm; the left arm swings."""
    calm = replace(carriage, twist=0.8 * carriage.twist)
    held = (-0.06 + random.uniform(-0.02, 0.02), -UPPER_ARM + random.uniform(0.0, 0.03), 0.25)
    cup = reaching_arm(RIGHT, _still(held, rhythm, bob=-0.004), (0.35, -1.0, -0.25))
    return trunk(calm, rhythm), {LEFT: swinging_arm(carriage, rhythm, LEFT), RIGHT: cup}


def _punch(carriage: Carriage, rhythm: Rhythm, random: np.random.Generator) -> Upper:
    """Throws straight punches from the guard, left and right in turn, each as the foot of the other side lands."""
    reach, drive = random.uniform(0.555, 0.565), random.uniform(0.85, 1.1)
    base = trunk(replace(carriage, twist=0.4 * carriage.twist), rhythm)
    arms, thrusts = {}, {}
    for side in (LEFT, RIGHT):
        since = np.mod(rhythm.swing + (0.5 if side == LEFT else 0.0) + 0.12, 1.0)
        thrust = ease(since / 0.17) - ease((since - 0.21) / 0.25)
        thrusts[side] = thrust
        guard = np.array([-0.08, 0.06, 0.25])
        target = np.array([0.08, 0.05, reach])
        arms[side] = reaching_arm(
            side,
            guard + (target - guard) * thrust[:, None],
            (0.45, -1.0, 0.1),
            pronation=0.25 + 1.2 * thrust,
        )
    turned = drive * np.radians(22.0) * (thrusts[RIGHT] - thrusts[LEFT])
    crouched = base.pitch + np.radians(4.0) + 0.05 * (thrusts[LEFT] + thrusts[RIGHT])
    return Trunk(base.yaw + turned, crouched, base.roll), arms


def _push(carriage: Carriage, rhythm: Rhythm, random: np.random.Generator) -> Upper:
    """Leans into something heavy, with both palms on it."""
    height, reach = random.uniform(-0.04, 0.02), random.uniform(0.54, 0.56)
    leaning = trunk(replace(carriage, twist=0.6 * carriage.twist), rhythm)
    leaning = replace(leaning, pitch=leaning.pitch + np.radians(random.uniform(16.0, 18.0)))
    wrist = _still((-0.02, height, reach), rhythm)
    arms = {side: reaching_arm(side, wrist, (0.7, -1.0, 0.0), pronation=1.35, extension=1.15) for side in (LEFT, RIGHT)}
    return leaning, arms


def _wave(carriage: Carriage, rhythm: Rhythm, random: np.random.Generator) -> Upper:
    """Waves the raised right hand at a rate of its own; the left arm swings."""
    rate, start = random.uniform(1.5, 1.9), random.uniform(0.0, 1.0)
    beat = np.sin(2.0 * np.pi * (rate * rhythm.time + start))
    late = np.sin(2.0 * np.pi * (rate * rhythm.time + start) - 0.7)
    swept = np.radians(16.0) + np.radians(21.0) * beat
    elbow = np.array([0.21, -0.15, 0.20])
    elbow *= UPPER_ARM / np.linalg.norm(elbow)
    lower = np.stack([np.sin(swept) * 0.97, np.cos(swept) * 0.97, np.full_like(swept, 0.24)], axis=-1)
    wrist = elbow + FOREARM * lower / np.linalg.norm(lower, axis=-1, keepdims=True)
    waving = reaching_arm(RIGHT, wrist, (0.9, -1.0, 0.3), pronation=1.3)
    waving = replace(waving, hand=quaternion.multiply(waving.fore, euler(-0.35 * late, 0.0, -0.1)))
    return trunk(carriage, rhythm), {LEFT: swinging_arm(carriage, rhythm, LEFT), RIGHT: waving}


ACTIONS: Mapping[str, Action] = MappingProxyType(
    {"carry_box": _carry_box, "carry_cup": _carry_cup, "punch": _punch, "push": _push, "wave": _wave}
)
