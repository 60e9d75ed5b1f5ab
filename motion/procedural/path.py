"""Where the body goes: position and heading as functions of time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from motionsplice.motion.quaternion import Floats

GRAVITY = 9.81


def forward(heading: Floats) -> Floats:
    """The unit vector [..., 3] over the floor at `heading` [...] radians about Y from +Z."""
    return np.stack([np.sin(heading), np.zeros_like(heading), np.cos(heading)], axis=-1)


def leftward(heading: Floats) -> Floats:
    """The unit vector [..., 3] over the floor to the left of `heading` [...]."""
    return np.stack([np.cos(heading), np.zeros_like(heading), -np.sin(heading)], axis=-1)


def ease(t: Floats) -> Floats:
    """From 0 to 1 over [0, 1], starting and ending with neither speed nor acceleration, held outside."""
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10.0 + t * (6.0 * t - 15.0))


@dataclass(frozen=True)
class Path:
    """Functions of time in seconds [n]: `position` -> [n, 3], `heading` -> [n], `pace` -> [n].

    The pace is the length of a step there against that of a full step: 1, but for where the body slows to turn.
    `ground` is the height [n] on which a foot stands that the path puts at points [n, 3]: theirs, if not given.
    """

    position: Callable[[Floats], Floats]
    heading: Callable[[Floats], Floats]
    pace: Callable[[Floats], Floats]
    ground: Callable[[Floats], Floats] = lambda points: points[:, 1]

    def lean(self, time: Floats) -> Floats:
        """The roll to the left [n] that balances the path's curvature, taken over half a second."""
        around = time[:, None] + np.linspace(-0.25, 0.25, 11)
        after, before = around.ravel() + 0.01, around.ravel() - 0.01
        turning = (self.heading(after) - self.heading(before)) / 0.02
        speed = np.linalg.norm(self.position(after) - self.position(before), axis=-1) / 0.02
        return np.asarray(np.arctan((speed * turning).reshape(around.shape).mean(axis=1) / GRAVITY))


def _even(t: Floats) -> Floats:
    return np.ones_like(t)


def straight(position: Callable[[Floats], Floats], ground: Callable[[Floats], Floats] | None = None) -> Path:
    """Facing +Z all the way; `position` and `ground` as in `Path`."""
    path = Path(position, np.zeros_like, _even)
    return path if ground is None else replace(path, ground=ground)


def circle(speed: float, radius: float) -> Path:
    """Forward along a circle to the left."""

    def position(t: Floats) -> Floats:
        angle = t * speed / radius
        return radius * np.stack([1.0 - np.cos(angle), np.zeros_like(t), np.sin(angle)], axis=-1)

    return Path(position, lambda t: t * speed / radius, _even)


def about_turn(speed: float, middle: float, lasting: float, slowest: float) -> Path:
    """Forward, half a turn to the left at time `middle` within `lasting` seconds, and back.

    The pace falls to `slowest` at the middle of the turn.
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
