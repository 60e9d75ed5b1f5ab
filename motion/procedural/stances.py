"""Standing actions: gestures captured from a person who stands, and their truth on any built-in locomotion.

The person stands at rest, performs one gesture and rests again. `Performer` says how the same person performs it while
walking. A performer who changes nothing flatters every method that adds a gesture to a locomotion; `FAIR` performers
keep hands and gaze steadier than the chest, hold the other arm back, and have their own timing and size.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.procedural import catalogue
from motionsplice.motion.procedural.actions import Upper, reaching_arm
from motionsplice.motion.procedural.body import ANKLE_HEIGHT, LEFT, RIGHT, SHANK, SKELETON, THIGH, euler
from motionsplice.motion.procedural.library import local_of, moving, upper_body
from motionsplice.motion.procedural.path import ease
from motionsplice.motion.procedural.upper import Arm, Carriage, Rhythm, Trunk, swinging_arms, trunk
from motionsplice.motion.quaternion import Floats

SECONDS = 5.0  # of every standing action
BEGIN, END = 1.1, 3.9  # seconds at which the gesture begins and ends


@dataclass(frozen=True)
class Gesture:
    """The motion of a gesture at times [F]: degrees of the chest, head and hips, and arms by side.

    strength: [F] 0 at rest, 1 in the gesture. yaw, pitch: of the chest. glance, nod: of the head, beyond the chest's.
    hips: the share of the chest's yaw and pitch that the hips of a person who stands make.
    """

    strength: Floats
    arms: Mapping[float, Arm]
    yaw: Floats
    pitch: Floats
    glance: Floats
    nod: Floats
    hips: float = 0.3


@dataclass(frozen=True)
class Performer:
    """How a person performs a gesture while walking.

    delay, tempo: seconds by which it begins later, and its speed. size: of the motion of chest and head.
    steady: the share of the chest's own sway that arms in the gesture, and the head, do not follow.
    held: the share of the swing that arms outside the gesture lose.
    hips: 1 if hips turn and lean with the chest while standing, else 0.
    hanging: the share of the chest's lean in the gesture that hanging arms do not follow.
    """

    delay: float = 0.0
    tempo: float = 1.0
    size: float = 1.0
    steady: float = 0.0
    held: float = 0.0
    hips: float = 0.0
    hanging: float = 0.0

    def times(self, time: Floats) -> Floats:
        """Returns the times [F] of the gesture that are shown at times [F]."""
        return np.asarray(BEGIN + (time - BEGIN - self.delay) * self.tempo)


def fair(seed: int) -> Performer:
    """Returns a performer with habits of their own."""
    random = np.random.default_rng([seed, 11])
    return Performer(
        delay=random.uniform(-0.08, 0.12),
        tempo=random.uniform(0.94, 1.06),
        size=random.uniform(0.85, 1.15),
        steady=random.uniform(0.4, 0.7),
        held=random.uniform(0.1, 0.3),
        hips=1.0,
        hanging=random.uniform(0.5, 0.8),
    )


def _rise(t: Floats, begin: float, end: float, lasting: float = 0.45) -> Floats:
    """Rises from 0 to 1 within `lasting` seconds from `begin` on, and falls back until `end`."""
    return ease((t - begin) / lasting) - ease((t - end) / lasting + 1.0)


def _hail(t: Floats, random: np.random.Generator) -> Gesture:
    """Raises the right hand and waves."""
    strength, beat = _rise(t, BEGIN, END), np.sin(2.0 * np.pi * random.uniform(1.4, 1.8) * (t - BEGIN))
    wrist = np.stack([0.22 + 0.09 * beat, np.full_like(t, 0.17), np.full_like(t, 0.26)], axis=-1)
    arm = reaching_arm(RIGHT, wrist, (0.9, -1.0, 0.3), pronation=1.3)
    still = 0.0 * t
    return Gesture(strength, {RIGHT: arm}, -4.0 * strength, still, -6.0 * strength, still)


def _jab(t: Floats, random: np.random.Generator) -> Gesture:
    """Takes up a guard, punches left and right, and drops the guard."""
    strength, reach = _rise(t, BEGIN, END), random.uniform(0.54, 0.565)
    arms, thrusts = {}, {}
    for side, begin in ((LEFT, 1.7), (RIGHT, 2.3)):
        thrust = _rise(t, begin, begin + 0.45, 0.2)
        guard, target = np.array([-0.07, 0.05, 0.25]), np.array([-0.05, 0.04, reach])
        wrist = guard + (target - guard) * thrust[:, None]
        arms[side], thrusts[side] = reaching_arm(side, wrist, (0.45, -1.0, 0.1), pronation=0.25 + 1.2 * thrust), thrust
    yaw = 26.0 * thrusts[RIGHT] - 20.0 * thrusts[LEFT]
    return Gesture(strength, arms, yaw, 5.0 * strength, 0.0 * t, 3.0 * strength, hips=0.45)


def _reload(t: Floats, random: np.random.Generator) -> Gesture:
    """Brings both hands together in front of the chest, looks down at them, and works."""
    strength, work = _rise(t, BEGIN, END), 0.05 * np.sin(2.0 * np.pi * random.uniform(0.9, 1.2) * (t - BEGIN))
    hold = np.stack([np.full_like(t, -0.1), np.full_like(t, -0.2), np.full_like(t, 0.3)], axis=-1)
    left = hold + np.stack([work, np.abs(work), 0.0 * t], axis=-1)
    arms = {
        side: reaching_arm(side, at, (0.6, -1.0, -0.2), pronation=0.4) for side, at in ((LEFT, left), (RIGHT, hold))
    }
    return Gesture(strength, arms, 6.0 * strength, 8.0 * strength, 0.0 * t, 22.0 * strength)


def _point(t: Floats, random: np.random.Generator) -> Gesture:
    """Points to the left with the left arm, and looks there."""
    strength, aside = _rise(t, BEGIN, END, 0.55), random.uniform(0.2, 0.3)
    wrist = np.tile([aside, 0.1, 0.43], (len(t), 1))
    arm = reaching_arm(LEFT, wrist, (0.7, -1.0, -0.2), pronation=1.2)
    return Gesture(strength, {LEFT: arm}, 16.0 * strength, 0.0 * t, 26.0 * strength, -3.0 * strength)


def _bow(t: Floats, random: np.random.Generator) -> Gesture:
    """Bows with the trunk and the head; the arms hang."""
    strength = _rise(t, BEGIN, END, 0.9)
    return Gesture(strength, {}, 0.0 * t, random.uniform(26.0, 32.0) * strength, 0.0 * t, 14.0 * strength)


_GESTURES: Mapping[str, Callable[[Floats, np.random.Generator], Gesture]] = MappingProxyType(
    {"hail": _hail, "jab": _jab, "reload": _reload, "point": _point, "bow": _bow}
)
STANDING: tuple[str, ...] = tuple(_GESTURES)
"""Names of the built-in standing actions."""


def _gesture(name: str, seed: int, t: Floats) -> Gesture:
    return _GESTURES[name](t, np.random.default_rng([seed, 100 + STANDING.index(name)]))


def standing_action(name: str, performer: Performer, *, seed: int = 0, rate: float = 60.0) -> Clip:
    """Generates a person who stands and performs the gesture. Of the performer, only `hips` and `hanging` matter."""
    time = np.arange(round(SECONDS * rate) + 1) / rate
    still = np.zeros(len(time))
    random = np.random.default_rng([seed, 200 + STANDING.index(name)])
    aside = np.radians(1.2) * np.sin(0.9 * time + random.uniform(0.0, 6.0)) * np.cos(0.37 * time + 1.0)
    facing = still + random.uniform(-np.pi, np.pi)
    gesture = _gesture(name, seed, time)
    yaw, pitch = (gesture.hips * performer.hips * np.radians(degrees) for degrees in (gesture.yaw, gesture.pitch))
    legs = [f"{side}{part}" for side in ("Left", "Right") for part in ("UpLeg", "Leg", "Foot", "ToeBase")]
    pelvis = euler(facing + 0.3 * aside + yaw, pitch, still)
    rhythm = Rhythm(still, still, still, facing + aside, facing + 0.7 * aside, still, time)
    carriage = catalogue.LOCOMOTIONS["walk"].carriage(still)
    world = dict.fromkeys(legs, euler(facing + 0.3 * aside, still, still)) | {"Hips": pelvis}
    world |= upper_body(pelvis, rhythm, *_performed(carriage, rhythm, gesture, Performer(hanging=performer.hanging)))
    height = 0.03 + THIGH + SHANK + ANKLE_HEIGHT
    return Clip(name, SKELETON, rate, np.tile([0.0, height, 0.0], (len(time), 1)), local_of(world))


def standing_truth(
    locomotion: str,
    name: str,
    performer: Performer,
    *,
    locomotion_seed: int,
    seed: int = 0,
    seconds: float = 6.0,
    rate: float = 60.0,
) -> Clip:
    """Generates the gesture of `standing_action` as performed on a locomotion, from its first frame on."""

    def upper(carriage: Carriage, rhythm: Rhythm) -> Upper:
        return _performed(carriage, rhythm, _gesture(name, seed, performer.times(rhythm.time)), performer)

    return moving(f"{locomotion}+{name}", locomotion, upper, seconds, rate, locomotion_seed)


def _performed(carriage: Carriage, rhythm: Rhythm, gesture: Gesture, performer: Performer) -> Upper:
    own, strength = trunk(carriage, rhythm), gesture.strength
    turned, leant = performer.size * np.radians(gesture.yaw), performer.size * np.radians(gesture.pitch)
    chest = Trunk(
        yaw=own.yaw + turned,
        pitch=own.pitch + leant,
        roll=own.roll,
        glance=performer.size * np.radians(gesture.glance) - 0.15 * performer.steady * strength * own.yaw,
        nod=performer.size * np.radians(gesture.nod),
    )
    calm = replace(chest, yaw=turned, pitch=leant + np.mean(own.pitch), roll=0.0 * own.roll)
    swaying, steady = (euler(one.yaw, one.pitch, one.roll) for one in (chest, calm))
    follow = quaternion.multiply(
        quaternion.conjugate(swaying), quaternion.slerp(swaying, steady, performer.steady * strength)
    )
    held = replace(carriage, swing=carriage.swing * (1.0 - performer.held * strength))
    arms = {}
    upright = euler(0.0, -performer.hanging * leant, 0.0)
    for side, arm in swinging_arms(held, rhythm).items():
        arm = Arm(*(quaternion.multiply(upright, part) for part in (arm.upper, arm.fore, arm.hand)))
        if side in gesture.arms:
            parts = ((getattr(arm, part), getattr(gesture.arms[side], part)) for part in ("upper", "fore", "hand"))
            arm = Arm(*(quaternion.slerp(free, quaternion.multiply(follow, bound), strength) for free, bound in parts))
        arms[side] = arm
    return chest, arms
