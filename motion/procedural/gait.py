"""The lower body: feet planned on the floor, the pelvis over them, and legs that join the two.

The norms' curves (see `curves`) give the swing foot's path and the height of the pelvis; the feet in stance stay
where they were put, rolling over heel and ball; the legs are solved for both. So knees and hips follow the norms
while no foot slides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
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
LEAVE, LAND = 0.12, 0.1  # phases over which a foot goes from the ground's path to the swing's, and back
LANDED = 0.07  # the phase by which a foot has come to rest after heel strike
LONGEST = 0.998 * (THIGH + SHANK)  # a leg is never quite straight


@dataclass(frozen=True)
class Gait:
    """How a locomotion steps. Phases in cycles from the left heel strike, lengths in metres, angles in radians.

    A stride takes `period` seconds and goes `stride` forward and `rise` up; a foot stands for `duty` of it.
    `norm` is absent where the literature has none (side-steps): then `foot` alone shapes the swing, and the
    pelvis is `lowered` from where the legs would be straight. `lift` raises the swing foot further. The feet are
    `width` apart. The pelvis tilts forward, drops on the swing side and turns by the three `pelvis_` angles, and
    moves over the standing foot by `sway`. `bob` is the amplitude of its height where the norm is not to say it (a
    run's flight): lowest at mid-stance, or highest if negative.
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
        """The hips' height over a step, as coefficients of `_harmonics`."""
        return self._fit[0]

    @cached_property
    def surge(self) -> Floats:
        """How far the hips are ahead of even speed, less how far a foot is put ahead of them, likewise."""
        return self._fit[1]

    @cached_property
    def _fit(self) -> tuple[Floats, Floats]:
        """Where the hips must be for a leg that stands to bend as the norm says, in the least squares."""
        bob = -self.bob * np.array([0.0, np.cos(TURN * self.duty), np.sin(TURN * self.duty), 0.0, 0.0])
        if self.norm is None:
            bob[0] = THIGH + SHANK + ANKLE_HEIGHT - _hip(LEFT)[1] - self.lowered
            return bob, np.zeros(5)
        u = np.linspace(0.0, self.duty, 200)
        basis = _harmonics(u)
        hip = quaternion.rotate(euler(*self.pelvis_turn(u)), _hip(LEFT))
        ahead, up = _ankle(self.norm, u)
        roll_ahead, roll_up = rocker(self.foot(u))
        travelled = u - 0.5 * self.duty
        surge = _fitted(basis, roll_ahead - self.stride * travelled - hip[:, 2] - ahead)
        apart = roll_ahead - self.stride * travelled - hip[:, 2] - basis @ surge
        length = np.minimum(np.hypot(ahead, up), LONGEST)
        aside = 0.5 * self.width - hip[:, 0] - self.sway * np.cos(TURN * travelled)
        tall = np.sqrt(np.maximum(length**2 - apart**2 - aside**2, 0.25))
        level = ANKLE_HEIGHT + roll_up + tall - hip[:, 1] - self.rise * travelled
        if self.bob:
            bob[0] = np.mean(level - basis @ bob)
            return bob, surge
        return _fitted(basis, level), surge


def _hip(side: float) -> Floats:
    return SKELETON.offsets[SKELETON.index(side_name(side) + "UpLeg")]


def _harmonics(phase: Floats) -> Floats:
    step = 2.0 * TURN * phase
    return np.stack([np.ones_like(step), np.cos(step), np.sin(step), np.cos(2 * step), np.sin(2 * step)], axis=-1)


def _fitted(basis: Floats, values: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(basis, values, rcond=None)[0], np.float64)


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
    z: Floats = np.where(heel, -HEEL[0], -BALL[0])
    y = np.where(heel, -HEEL[1], -BALL[1]).astype(np.float64)
    sine, cosine = np.sin(pitch), np.cos(pitch)
    return z * cosine - y * sine - z, z * sine + y * cosine - y


def _progress(gait: Gait, u: Floats) -> Floats:
    """How much of the way to its next place a foot has gone, and turned: all of it shortly before it lands."""
    return ease((u - gait.duty) / (0.9 * (1.0 - gait.duty)))


def _swing(gait: Gait, u: Floats) -> Floats:
    """The ankle's path in swing against its place over the flat foot it left, forward and up: [n, 2]."""
    s = (u - gait.duty) / (1.0 - gait.duty)
    lift = gait.lift * 64.0 * (s * (1.0 - s)) ** 3
    if gait.norm is None:
        ahead, up = rocker(gait.foot(u))
        progress = _progress(gait, u)
        return np.stack([ahead + gait.stride * progress, up + gait.rise * progress + lift], axis=-1)
    hip = quaternion.rotate(euler(*gait.pelvis_turn(u)), _hip(LEFT))
    ahead, up = _ankle(gait.norm, u)
    travelled = u - 0.5 * gait.duty
    height = _harmonics(u) @ gait.height + gait.rise * travelled - ANKLE_HEIGHT
    along = _harmonics(u) @ gait.surge + gait.stride * travelled
    return np.stack([along + hip[:, 2] + ahead, height + hip[:, 1] + up + lift], axis=-1)


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
    cycle = np.floor(phase - LANDED)
    first = int(cycle.min())
    at = (np.arange(first, int(cycle.max()) + 2, dtype=np.float64) + 0.5 * gait.duty - offset) * gait.period
    yaw = path.heading(at)
    place = path.position(at) + leftward(yaw) * (0.5 * side * gait.width)
    yaw = yaw + side * gait.toe_out
    pace = path.pace(at)
    index = cycle.astype(np.int64) - first
    u = phase - cycle
    s = np.clip((u - gait.duty) / (1.0 - gait.duty), 0.0, 1.0)
    eased = _progress(gait, u)

    def between(values: Floats) -> Floats:
        return values[index] + (values[index + 1] - values[index]) * eased

    pitch = gait.foot(u) * between(pace)
    foot_yaw = between(yaw)
    # In swing the foot follows the norm; just off and just before the ground it still, or already, rolls there.
    leaving = 1.0 - ease((u - gait.duty) / LEAVE + 0.35)
    landing = ease((u - 1.0 - LANDED) / LAND + 1.0)
    rolled = np.stack(rocker(pitch), axis=-1)
    moved = _swing(gait, np.maximum(u, 0.5 * gait.duty)) - eased[:, None] * np.array([gait.stride, gait.rise])
    stepping = between(pace)
    moved *= np.stack([stepping, 0.4 + 0.6 * stepping], axis=-1)

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


def lower_body(gait: Gait, path: Path, time: Floats, start: float, lean: Callable[[Floats], Floats]) -> LowerBody:
    """The lower body at times [F] seconds; `lean`, of times, is the roll to the left in radians."""
    root, pelvis, feet = _planned(gait, path, time, start, lean)
    root = root - UP * _sink(gait, path, time, start, lean)[:, None]
    phase = time / gait.period + start
    heading = path.heading(time) + gait.pelvis_turn(phase)[0]
    world = {"Hips": pelvis}
    for side, one in feet.items():
        name = side_name(side)
        hip = root + quaternion.rotate(pelvis, _hip(side))
        pole = forward(0.5 * (heading + one.yaw))
        leg = two_bones(one.ankle - hip, pole, THIGH, SHANK)
        ankle = euler(one.yaw, -one.pitch, 0.0)
        world[name + "UpLeg"] = frame(leg.hinge, -leg.upper)
        world[name + "Leg"] = frame(leg.hinge, -leg.lower)
        world[name + "Foot"] = ankle
        world[name + "ToeBase"] = quaternion.multiply(ankle, quaternion.about([1.0, 0.0, 0.0], -one.toes))
    return LowerBody(root, world, phase)


def _planned(
    gait: Gait, path: Path, time: Floats, start: float, lean: Callable[[Floats], Floats]
) -> tuple[Floats, Floats, dict[float, Foot]]:
    """Root positions [F, 3], pelvis rotations [F, 4] and feet, before any leg is asked whether it can reach."""
    phase = time / gait.period + start
    heading, pace, rolled = path.heading(time), path.pace(time), lean(time)
    yaw, pitch, roll = gait.pelvis_turn(phase)
    pelvis = euler(heading + yaw * pace, pitch, roll * pace - 0.5 * rolled)
    bob, surge = _harmonics(phase), (_harmonics(phase) @ gait.surge) * pace
    bob[:, 1:] *= (pace**2)[:, None]
    aside = gait.sway * np.cos(TURN * (phase - 0.5 * gait.duty)) + 0.5 * np.tan(rolled)
    root = path.position(time) + forward(heading) * surge[:, None] + leftward(heading) * aside[:, None]
    root = root + UP * (bob @ gait.height)[:, None]
    return root, pelvis, {side: foot(gait, path, side, time, start) for side in (LEFT, RIGHT)}


def _sink(gait: Gait, path: Path, time: Floats, start: float, lean: Callable[[Floats], Floats]) -> Floats:
    """How far [F] the hips must sink, smoothly, so that no leg reaches further than `LONGEST`.

    It is worked out on a time grid of its own, beyond both ends, so that neither rate nor ends show in it.
    """
    rate, radius = 100.0, 10
    margin = 2.0 * radius / rate
    grid = np.arange(time[0] - margin, time[-1] + margin + 2.0 / rate, 1.0 / rate)
    root, pelvis, feet = _planned(gait, path, grid, start, lean)
    excess = np.zeros(len(grid))
    for side, one in feet.items():
        leg = root + quaternion.rotate(pelvis, _hip(side)) - one.ankle
        tallest = np.sqrt(np.maximum(LONGEST**2 - leg[:, 0] ** 2 - leg[:, 2] ** 2, 0.01))
        excess = np.maximum(excess, leg[:, 1] - tallest)
    # The blur's kernel is no wider than the maximum's window, so the result nowhere falls below the excess.
    return CubicSpline(grid, gaussian_filter1d(maximum_filter1d(excess, 2 * radius + 1), radius / 3, radius=radius))(
        time
    )
