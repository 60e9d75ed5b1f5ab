"""Gaits: the motion of feet, pelvis and hips within one stride.

The norms (see `curves`) determine the path of the swing foot and the height of the hips.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.procedural.body import ANKLE_HEIGHT, BALL, HEEL, LEFT, SHANK, SKELETON, THIGH, euler, side_name
from motionsplice.motion.procedural.curves import Curve, Norm
from motionsplice.motion.procedural.path import ease
from motionsplice.motion.quaternion import Floats

TURN = 2.0 * np.pi
LONGEST = 0.998 * (THIGH + SHANK)  # metres; a leg is never quite straight


@dataclass(frozen=True)
class Gait:
    """The parameters of a gait. Phases in cycles from the left heel strike, lengths in metres, angles in radians.

    period:     seconds of a stride.
    stride, rise: how far a stride goes forward and up.
    duty:       the fraction of a stride for which a foot is in stance.
    width:      distance between the left and right footholds.
    foot:       pitch of the foot over its own cycle.
    norm:       angles of thigh and knee; None where the literature has none (side-steps). Then `foot` alone shapes the
                swing, and the pelvis is `lowered` from the height at which the legs would be straight.
    lift:       extra height of the swing foot.
    toe_out:    outward turn of the feet.
    pelvis_tilt, pelvis_list, pelvis_rotation: how far the pelvis tilts forward, drops on the swing side and turns.
    sway:       how far the pelvis moves over the standing foot.
    bob:        amplitude of the pelvis's height where the norm does not give it (the flight of a run): lowest at
                mid-stance, or highest if negative.
    forefoot:   1 if the foot lands on the forefoot with level toes, else 0.
    rising:     the first part of the swing, in which a foot rises to a foothold higher than `rise` gives.
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
    forefoot: float = 0.0
    rising: float = 0.8

    def swing(self, u: Floats) -> Floats:
        """Returns the swinging ankle's offset from even motion between footholds: forward and up, [n, 2]."""
        s = (u - self.duty) / (1.0 - self.duty)
        lift = self.lift * 64.0 * (s * (1.0 - s)) ** 3
        if self.norm is None:
            ahead, up = rocker(self.foot(u))
            return np.stack([ahead, up + lift], axis=-1)
        hip = quaternion.rotate(euler(*self.pelvis_turn(u)), hip_of(LEFT))
        ahead, up = _ankle(self.norm, u)
        travelled = u - 0.5 * self.duty - progress(u, self.duty)
        height = harmonics(u) @ self.height + self.rise * travelled - ANKLE_HEIGHT
        along = harmonics(u) @ self.surge + self.stride * travelled
        return np.stack([along + hip[:, 2] + ahead, height + hip[:, 1] + up + lift], axis=-1)

    def pelvis_turn(self, phase: Floats) -> tuple[Floats, Floats, Floats]:
        """Returns yaw, pitch and roll of the pelvis relative to the heading, each [n], at phases [n]."""
        yaw = -self.pelvis_rotation * np.cos(TURN * (phase - 0.02))
        pitch = self.pelvis_tilt + 0.2 * self.pelvis_list * np.cos(2.0 * TURN * (phase - 0.1))
        roll = self.pelvis_list * (np.sin(TURN * phase + 0.55) + 0.25 * np.sin(3.0 * TURN * phase + 0.4)) / 1.1
        return yaw, pitch, roll

    @cached_property
    def height(self) -> Floats:
        """The height of the hips over a step, as coefficients [5] of `harmonics`."""
        return self._fit[0]

    @cached_property
    def surge(self) -> Floats:
        """How far the hips are ahead of even speed, minus how far a foot lands ahead of them, as coefficients [5]."""
        return self._fit[1]

    @cached_property
    def _fit(self) -> tuple[Floats, Floats]:
        """Fits height and surge of the hips, by least squares, so that the standing leg bends as in the norm."""
        bob = -self.bob * np.array([0.0, np.cos(TURN * self.duty), np.sin(TURN * self.duty), 0.0, 0.0])
        if self.norm is None:
            bob[0] = THIGH + SHANK + ANKLE_HEIGHT - hip_of(LEFT)[1] - self.lowered
            return bob, np.zeros(5)
        u = np.linspace(0.0, self.duty, 200)
        basis = harmonics(u)
        hip = quaternion.rotate(euler(*self.pelvis_turn(u)), hip_of(LEFT))
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


def hip_of(side: float) -> Floats:
    """Returns the hip joint's offset from the root [3]."""
    return SKELETON.offsets[SKELETON.index(side_name(side) + "UpLeg")]


def harmonics(phase: Floats) -> Floats:
    """Returns the Fourier basis of a step (half a cycle) up to its second harmonic. [n] -> [n, 5]."""
    step = 2.0 * TURN * phase
    return np.stack([np.ones_like(step), np.cos(step), np.sin(step), np.cos(2 * step), np.sin(2 * step)], axis=-1)


def _fitted(basis: Floats, values: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(basis, values, rcond=None)[0], np.float64)


def _ankle(norm: Norm, phase: Floats) -> tuple[Floats, Floats]:
    """Returns the ankle's offset from the hip in the norm: forward and up, each [n]."""
    thigh = norm.thigh(phase)
    shank = thigh - norm.knee(phase)
    return THIGH * np.sin(thigh) + SHANK * np.sin(shank), -THIGH * np.cos(thigh) - SHANK * np.cos(shank)


def rocker(pitch: Floats) -> tuple[Floats, Floats]:
    """Returns how far forward and up the ankle moves from its place over the flat foot as the foot rolls to `pitch`.

    A foot with its toes up (positive pitch) rolls about the heel, a foot with its heel up about the ball.
    """
    heel = pitch > 0.0
    z: Floats = np.where(heel, -HEEL[0], -BALL[0])
    y = np.where(heel, -HEEL[1], -BALL[1]).astype(np.float64)
    sine, cosine = np.sin(pitch), np.cos(pitch)
    return z * cosine - y * sine - z, z * sine + y * cosine - y


def progress(u: Floats, duty: float | Floats) -> Floats:
    """Returns the fraction of its way to the next foothold that a foot has covered: 1 shortly before it lands."""
    return ease((u - duty) / (0.9 * (1.0 - duty)))
