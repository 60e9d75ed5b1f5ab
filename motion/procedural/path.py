"""Paths: position, heading and pace of the body as functions of time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from motionsplice.motion.quaternion import Floats

GRAVITY = 9.81  # metres per second squared


def forward(heading: Floats) -> Floats:
    """Returns the horizontal unit vector [..., 3] at `heading` [...] radians about Y from +Z."""
    return np.stack([np.sin(heading), np.zeros_like(heading), np.cos(heading)], axis=-1)


def leftward(heading: Floats) -> Floats:
    """Returns the horizontal unit vector [..., 3] to the left of `heading` [...]."""
    return np.stack([np.cos(heading), np.zeros_like(heading), -np.sin(heading)], axis=-1)


def ease(t: Floats) -> Floats:
    """Rises from 0 to 1 over [0, 1], with zero speed and acceleration at both ends; constant outside."""
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10.0 + t * (6.0 * t - 15.0))


@dataclass(frozen=True)
class Path:
    """A path as functions of time in seconds [n].

    position: [n, 3] metres.
    heading:  [n] radians about Y from +Z.
    pace:     [n] length of a step relative to a full step: 1, except where the body slows down to turn.
    ground:   of points [n, 3] on the path: the height [n] of the ground there, by default the points' own.
    """

    position: Callable[[Floats], Floats]
    heading: Callable[[Floats], Floats]
    pace: Callable[[Floats], Floats]
    ground: Callable[[Floats], Floats] = lambda points: points[:, 1]

    def lean(self, time: Floats) -> Floats:
        """Returns the roll to the left [n] in radians that balances the path's curvature, averaged over 0.5 s."""
        around = time[:, None] + np.linspace(-0.25, 0.25, 11)
        after, before = around.ravel() + 0.01, around.ravel() - 0.01
        turning = (self.heading(after) - self.heading(before)) / 0.02
        speed = np.linalg.norm(self.position(after) - self.position(before), axis=-1) / 0.02
        return np.asarray(np.arctan((speed * turning).reshape(around.shape).mean(axis=1) / GRAVITY))


def _even(t: Floats) -> Floats:
    return np.ones_like(t)


def straight(position: Callable[[Floats], Floats], ground: Callable[[Floats], Floats] | None = None) -> Path:
    """Returns a path that faces +Z throughout; `position` and `ground` as in `Path`."""
    path = Path(position, np.zeros_like, _even)
    return path if ground is None else replace(path, ground=ground)


def circle(speed: float, radius: float) -> Path:
    """Returns a path along a circle to the left; `speed` in metres per second, `radius` in metres."""

    def position(t: Floats) -> Floats:
        angle = t * speed / radius
        return radius * np.stack([1.0 - np.cos(angle), np.zeros_like(t), np.sin(angle)], axis=-1)

    return Path(position, lambda t: t * speed / radius, _even)


def about_turn(speed: float, middle: float, lasting: float, slowest: float) -> Path:
    """Returns a path forward, half a turn to the left within `lasting` seconds around time `middle`, and back.

    The pace falls to `slowest` in the middle of the turn.
    """
    grid = middle + np.linspace(-12.0, 12.0, 2401)

    def heading(t: Floats) -> Floats:
        return np.pi * ease((t - middle) / lasting + 0.5)

    def pace(t: Floats) -> Floats:
        return 1.0 - (1.0 - slowest) * ease(1.0 - np.abs(t - middle) / lasting)

    velocity = CubicSpline(grid, speed * pace(grid)[:, None] * forward(heading(grid)))
    travelled = velocity.antiderivative()
    start = travelled(0.0)

    def position(t: Floats) -> Floats:
        return travelled(t) - start

    return Path(position, heading, pace)
