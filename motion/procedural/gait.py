"""The lower body: feet planned on the floor, the pelvis over them, and legs that join the two.

The norms' curves (see `curves`) give the swing foot's path and the height of the pelvis; the feet in stance stay
where they were put, rolling over heel and ball; the legs are solved for both. So knees and hips follow the norms
while no foot slides.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from motion import quaternion
from motion.procedural.body import (
    ANKLE_HEIGHT,
    BALL,
    HEEL,
    LEFT,
    RIGHT,
    SHANK,
    SKELETON,
    THIGH,
    UP,
    euler,
    frame,
    side_name,
    two_bones,
)
from motion.procedural.curves import Curve, Norm
from motion.procedural.path import Path, ease, forward, leftward
from motion.quaternion import Floats

TURN = 2.0 * np.pi
LEAVE, LAND = 0.14, 0.16  # phases over which a foot goes from the ground's path to the swing's, and back
LONGEST = 0.9985 * (THIGH + SHANK)  # a leg is never quite straight


@dataclass(frozen=True)
class Gait:
    """How a locomotion steps. Phases in cycles from the left heel strike, lengths in metres, angles in radians.

    A stride takes `period` seconds and goes `stride` forward and `rise` up; a foot stands for `duty` of it.
    `norm` is absent where the literature has none (side-steps): then `foot` alone shapes the swing, and the
    pelvis is `lowered` from where the legs would be straight. `lift` raises the swing foot further.
    """

    period: float
    stride: float
    duty: float
    width: float
    foot: Curve
    norm: Norm | None = None
    rise: float = 0.0
    lift: float = 0.0
    lowered: float = 0.0
    toe_out: float = 0.1
    pelvis_tilt: float = 0.0
    pelvis_list: float = 0.0
    pelvis_rotation: float = 0.0
    sway: float = 0.0
    bob: float = 0.0

    def pelvis_turn(self, phase: Floats) -> tuple[Floats, Floats, Floats]:
        """Yaw, pitch and roll of the pelvis against the heading, at phases [n]."""
        yaw = -self.pelvis_rotation * np.cos(TURN * (phase - 0.02))
        pitch = self.pelvis_tilt + 0.2 * self.pelvis_list * np.cos(2.0 * TURN * (phase - 0.1))
        roll = self.pelvis_list * (np.sin(TURN * phase + 0.55) + 0.25 * np.sin(3.0 * TURN * phase + 0.4)) / 1.1
        return yaw, pitch, roll

    @cached_property
    def height(self) -> Floats:
        """Fourier coefficients of the hips' height: mean, then cosine and sine of once and twice a step."""
        return self._fit[0]

    @cached_property
    def reach(self) -> float:
        """How far ahead of the hips' place at mid-stance a foot is put."""
        return self._fit[1]

    @cached_property
    def _fit(self) -> tuple[Floats, float]:
        if self.norm is None:
            return np.array([THIGH + SHANK + ANKLE_HEIGHT + 0.03 - self.lowered, self.bob, 0.0, 0.0, 0.0]), 0.0
        u = np.linspace(0.0, self.duty, 200)
        hip = quaternion.rotate(euler(*self.pelvis_turn(u)), _hip(LEFT))
        ahead, up = _ankle(self.norm, u)
        roll_ahead, roll_up = rocker(self.foot(u))
        travelled = self.stride * (u - 0.5 * self.duty)
        shift = float(np.mean(travelled + hip[:, 2] + ahead - roll_ahead))
        apart = shift + roll_ahead - travelled - hip[:, 2]
        length = np.minimum(np.hypot(ahead, up), LONGEST)
        lateral = 0.5 * self.width - hip[:, 0] - self.sway * np.cos(TURN * (u - 0.5 * self.duty))
        level = np.sqrt(np.maximum(length**2 - apart**2 - lateral**2, 0.25))
        target = ANKLE_HEIGHT + roll_up + level - hip[:, 1] - self.rise * (u - 0.5 * self.duty)
        weight = np.sin(np.pi * u / self.duty) + 0.3
        fit, *_ = np.linalg.lstsq(_harmonics(u) * weight[:, None], target * weight, rcond=None)
        if self.bob:
            fit[1:] = -self.bob * np.array([np.cos(TURN * self.duty), np.sin(TURN * self.duty), 0.0, 0.0])
        return fit, shift


def _hip(side: float) -> Floats:
    return SKELETON.offsets[SKELETON.index(side_name(side) + "UpLeg")]


def _harmonics(phase: Floats) -> Floats:
    step = 2.0 * TURN * phase
    return np.stack([np.ones_like(step), np.cos(step), np.sin(step), np.cos(2 * step), np.sin(2 * step)], axis=-1)


def _ankle(norm: Norm, phase: Floats) -> tuple[Floats, Floats]:
    """Where the norm's ankle is against the hip: forward and up."""
    thigh = norm.thigh(phase)
    shank = thigh - norm.knee(phase)
    return THIGH * np.sin(thigh) + SHANK * np.sin(shank), -THIGH * np.cos(thigh) - SHANK * np.cos(shank)


def rocker(pitch: Floats) -> tuple[Floats, Floats]:
    """How far forward and up an ankle is of its place over the flat foot, when the foot rolls to `pitch`.

    It rolls about the heel with the toes up (positive), about the ball with the heel up.
    """
    heel = pitch > 0.0
    z, y = np.where(heel, -HEEL[0], -BALL[0]), np.where(heel, -HEEL[1], -BALL[1])
    sine, cosine = np.sin(pitch), np.cos(pitch)
    return z * cosine - y * sine - z, z * sine + y * cosine - y


def _swing(gait: Gait, u: Floats) -> Floats:
    """The ankle's path in swing against its place over the flat foot it left, forward and up: [n, 2]."""
    s = (u - gait.duty) / (1.0 - gait.duty)
    lift = gait.lift * 64.0 * (s * (1.0 - s)) ** 3
    if gait.norm is None:
        ahead, up = rocker(gait.foot(u))
        return np.stack([ahead + gait.stride * ease(s), up + gait.rise * ease(s) + lift], axis=-1)
    hip = quaternion.rotate(euler(*gait.pelvis_turn(u)), _hip(LEFT))
    ahead, up = _ankle(gait.norm, u)
    travelled = u - 0.5 * gait.duty
    height = _harmonics(u) @ gait.height + gait.rise * travelled - ANKLE_HEIGHT
    return np.stack([gait.stride * travelled + hip[:, 2] + ahead - gait.reach, height + hip[:, 1] + up + lift], axis=-1)


@dataclass(frozen=True)
class Foot:
    """Over F frames: the ankle [F, 3], the foot's yaw and pitch [F], and the bend of the toes [F]."""

    ankle: Floats
    yaw: Floats
    pitch: Floats
    toes: Floats


def foot(gait: Gait, path: Path, side: float, time: Floats, start: float) -> Foot:
    """The motion of one foot at times [F] seconds, for a clip that begins at phase `start`."""
    offset = start if side == LEFT else start + 0.5
    phase = time / gait.period + offset
    cycle = np.floor(phase)
    first = int(cycle.min())
    at = (np.arange(first, int(cycle.max()) + 2) + 0.5 * gait.duty - offset) * gait.period
    yaw = path.heading(at)
    place = path.position(at) + forward(yaw) * gait.reach + leftward(yaw) * (0.5 * side * gait.width)
    yaw = yaw + side * gait.toe_out
    pace = path.pace(at)
    index = cycle.astype(np.int64) - first
    u = phase - cycle
    s = np.clip((u - gait.duty) / (1.0 - gait.duty), 0.0, 1.0)
    eased = ease(s)

    def between(values: Floats) -> Floats:
        return values[index] + (values[index + 1] - values[index]) * eased

    pitch = gait.foot(u) * between(pace)
    foot_yaw = between(yaw)
    # In swing the foot follows the norm; just off and just before the ground it still, or already, rolls there.
    leaving, landing = 1.0 - ease((u - gait.duty) / LEAVE), ease((u - 1.0) / LAND + 1.0)
    rolled = np.stack(rocker(pitch), axis=-1)
    moved = _swing(gait, np.maximum(u, gait.duty)) - eased[:, None] * np.array([gait.stride, gait.rise])
    moved *= between(pace)[:, None]

    def on(ground: Floats, direction: Floats, offset: Floats) -> Floats:
        return ground + direction * offset[:, :1] + UP * (ANKLE_HEIGHT + offset[:, 1:])

    left, next_to = place[index], place[index + 1]
    ankle = (
        on(left, forward(yaw[index]), rolled) * leaving[:, None]
        + on(left + (next_to - left) * eased[:, None], forward(foot_yaw), moved) * (1.0 - leaving - landing)[:, None]
        + on(next_to, forward(yaw[index + 1]), rolled) * landing[:, None]
    )
    toes = np.maximum(-pitch, 0.0) * (1.0 - ease(s / 0.45))
    return Foot(ankle, foot_yaw, pitch, toes)


@dataclass(frozen=True)
class LowerBody:
    """Root positions [F, 3], world rotations [F, 4] by joint name, and the phase [F] of the left foot."""

    root: Floats
    world: dict[str, Floats]
    phase: Floats


def lower_body(gait: Gait, path: Path, time: Floats, start: float, lean: Floats) -> LowerBody:
    """The lower body at times [F] seconds; `lean` [F] radians rolls the pelvis into a curve."""
    phase = time / gait.period + start
    heading = path.heading(time)
    yaw, pitch, roll = gait.pelvis_turn(phase)
    pace = path.pace(time)
    pelvis = euler(heading + yaw * pace, pitch, roll * pace - lean)
    bob = _harmonics(phase)
    bob[:, 1:] *= (pace**2)[:, None]
    height = bob @ gait.height
    aside = gait.sway * np.cos(TURN * (phase - 0.5 * gait.duty)) + np.tan(lean) * 0.6
    root = path.position(time) + leftward(heading) * aside[:, None] + UP * height[:, None]
    feet = {side: foot(gait, path, side, time, start) for side in (LEFT, RIGHT)}
    root = root - UP * _overreach(root, pelvis, feet)[:, None]
    world = {"Hips": pelvis}
    for side, one in feet.items():
        name = side_name(side)
        hip = root + quaternion.rotate(pelvis, _hip(side))
        pole = forward(0.5 * (heading + yaw + one.yaw))
        leg = two_bones(one.ankle - hip, pole, THIGH, SHANK)
        ankle = euler(one.yaw, -one.pitch, 0.0)
        world[name + "UpLeg"] = frame(leg.hinge, -leg.upper)
        world[name + "Leg"] = frame(leg.hinge, -leg.lower)
        world[name + "Foot"] = ankle
        world[name + "ToeBase"] = quaternion.multiply(ankle, quaternion.about([1.0, 0.0, 0.0], -one.toes))
    return LowerBody(root, world, phase)


def _overreach(root: Floats, pelvis: Floats, feet: dict[float, Foot]) -> Floats:
    """How far [F] the hips must sink, smoothly over frames, so that no leg is longer than it can be."""
    sink = np.zeros(len(root))
    for side, one in feet.items():
        leg = root + quaternion.rotate(pelvis, _hip(side)) - one.ankle
        tallest = np.sqrt(np.maximum(LONGEST**2 - leg[:, 0] ** 2 - leg[:, 2] ** 2, 0.01))
        sink = np.maximum(sink, leg[:, 1] - tallest)
    if not sink.any():
        return sink
    return gaussian_filter1d(maximum_filter1d(sink, 9), 4.0, mode="nearest")
