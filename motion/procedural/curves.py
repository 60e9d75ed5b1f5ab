"""Periodic joint-angle curves over the gait cycle, in cycles from heel strike, after published norms.

The angles, in degrees at every 5 % of the cycle, follow published curves to within a few degrees; they are not copied
from tables. Sources: walking, Winter (1991), The Biomechanics and Motor Control of Human Gait, and Perry (1992), Gait
Analysis; running, Novacheck (1998), The biomechanics of running; stairs, Riener, Rabuffetti and Frigo (2002), Stair
ascent and descent at different inclinations.

The thigh's angle is to the vertical, forward positive, and so smaller than the hip's flexion by the pelvis's tilt. The
knee's is its flexion. The foot's is its pitch to the floor, toes up positive; its keys keep it exactly flat in stance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.quaternion import Floats

Curve = Callable[[Floats], Floats]  # phases [n] in cycles -> radians [n]

_GRID = 400  # samples of a cycle
_BLUR = 0.012  # of a cycle


def fourier(samples: tuple[float, ...], harmonics: int) -> Curve:
    """Returns the curve of a Fourier series of `harmonics`, fitted to degrees evenly spaced over a cycle."""
    spectrum = np.fft.rfft(np.radians(samples)) / len(samples)
    order = np.arange(1, harmonics + 1)

    def curve(phase: Floats) -> Floats:
        waves = np.exp(np.multiply.outer(phase, 2j * np.pi * order))
        return np.asarray(spectrum[0].real + 2.0 * (waves @ spectrum[1 : harmonics + 1]).real)

    return curve


def keyed(keys: tuple[tuple[float, float], ...]) -> Curve:
    """Returns a smooth periodic curve near keys (phase in [0, 1), degrees), flat where successive keys are equal."""
    at, value = np.array(keys).T
    at = np.concatenate([at - 1.0, at, at + 1.0])
    grid = np.arange(_GRID) / _GRID
    samples = PchipInterpolator(at, np.tile(np.radians(value), 3))(grid)
    smooth = gaussian_filter1d(samples, _BLUR * _GRID, mode="wrap", truncate=3.0)
    spline = CubicSpline(np.arange(_GRID + 1) / _GRID, np.append(smooth, smooth[0]), bc_type="periodic")
    return lambda phase: np.asarray(spline(np.mod(phase, 1.0)))


def scaled(curve: Curve, factor: float) -> Curve:
    """Returns the curve multiplied by `factor`."""
    return lambda phase: factor * curve(phase)


@dataclass(frozen=True)
class Norm:
    """The sagittal motion of one leg over a cycle."""

    thigh: Curve
    knee: Curve

    def scaled(self, factor: float) -> Norm:
        """Returns the same motion with angles multiplied by `factor`."""
        return Norm(scaled(self.thigh, factor), scaled(self.knee, factor))


WALK = Norm(
    thigh=fourier(
        (22, 21.5, 19, 15.5, 12, 8, 3.5, -1, -6, -10.5, -14, -14.5, -10, -1, 9, 17, 22, 25, 25.5, 24), harmonics=6
    ),
    knee=fourier(
        (6, 12, 18, 20.5, 19.5, 16, 12, 9, 7.5, 8.5, 13, 22.5, 37, 52.5, 61.5, 61, 53, 39, 21, 8), harmonics=7
    ),
)
WALK_FOOT = keyed(
    (
        *((0.0, 23), (0.04, 12), (0.085, 1), (0.10, 0), (0.36, 0), (0.42, -4), (0.50, -17), (0.56, -34)),
        *((0.62, -56), (0.66, -64), (0.72, -57), (0.78, -36), (0.84, -12), (0.90, 9), (0.95, 20)),
    )
)
RUN = Norm(
    thigh=fourier((23, 23, 20, 15, 8, 0, -8, -15, -19, -18, -13, -4, 6, 15, 23, 30, 35, 36, 33, 28), harmonics=6),
    knee=fourier((17, 29, 39, 43, 42, 36, 28, 22, 20, 26, 40, 58, 77, 93, 101, 98, 83, 59, 34, 18), harmonics=7),
)
RUN_FOOT = keyed(
    (
        *((0.0, 9), (0.04, 2), (0.06, 0), (0.15, 0), (0.21, -10), (0.29, -34), (0.36, -52), (0.45, -62)),
        *((0.55, -77), (0.64, -84), (0.72, -74), (0.80, -46), (0.88, -14), (0.95, 8)),
    )
)
STAIRS_UP = Norm(
    thigh=fourier((52, 49, 44, 38, 32, 27, 22, 18, 14, 11, 8, 7, 9, 18, 33, 48, 58, 61, 59, 55), harmonics=6),
    knee=fourier((62, 60, 56, 50, 43, 36, 29, 23, 18, 15, 13, 16, 28, 50, 73, 88, 90, 83, 73, 66), harmonics=7),
)
STAIRS_UP_FOOT = keyed(
    (
        *((0.0, 2), (0.04, 0), (0.44, 0), (0.52, -9), (0.58, -22), (0.63, -33), (0.67, -34), (0.76, -16)),
        *((0.86, 3), (0.93, 6)),
    )
)
STAIRS_DOWN = Norm(
    thigh=fourier((17, 18.5, 19, 18, 16, 14, 12, 11.5, 13, 17, 23, 30, 36, 40, 41, 39, 35.5, 31, 25, 19), harmonics=6),
    knee=fourier((17, 22, 25, 25, 24, 23, 23, 26, 33, 44, 58, 73, 85, 92, 91, 82, 66, 46, 28, 17), harmonics=7),
)
STAIRS_DOWN_FOOT = keyed(
    (
        *((0.0, -21), (0.04, -13), (0.09, -1), (0.11, 0), (0.34, 0), (0.40, -3), (0.48, -10), (0.56, -23)),
        *((0.63, -40), (0.68, -47), (0.75, -41), (0.83, -28), (0.90, -23), (0.95, -23)),
    )
)
SIDE_STEP_FOOT = keyed(((0.0, -4), (0.06, 0), (0.50, 0), (0.58, -9), (0.64, -20), (0.74, -16), (0.84, -6), (0.93, -5)))
