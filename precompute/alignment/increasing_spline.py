"""A strictly increasing cubic B-spline through a time alignment, in time linear in its length.

Heck et al. 2006, 3.1: "we fit a strictly increasing, endpoint interpolating B-spline to the optimal path". The spline's
ends are its first and last coefficients. Here they are fitted like all others, since a path's ends are only whole
frames. A B-spline with strictly increasing coefficients is strictly increasing. So the fit is a least-squares problem
in which each coefficient must lie a little above the previous one: a quadratic programme with banded matrices.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.linalg import LinAlgError
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline
from scipy.linalg.lapack import dpbsv

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats

DEGREE = 3
LEAST_SLOPE = 0.25  # of the mean slope: the least slope of a path through the grid
MOST_STEPS = 60


def fit_increasing(
    x: ArrayLike, y: ArrayLike, knot_spacing: float, stiffness: float = 0.0, least_slope: float = LEAST_SLOPE
) -> BSpline[np.float64]:
    """Returns the least-squares spline through (x, y) [n], on clamped knots, that rises everywhere between its ends.

    x, in frames or seconds, never falls (it may stay, as where a path climbs straight up); y is in frames or cycles.
    There is one knot per `knot_spacing` of x. x[-1] must be above x[0] and y[-1] above y[0]: the curve's slope is
    everywhere at least `least_slope` times the slope from end to end, and the fit starts from the straight line.
    `stiffness` weighs the squared changes of slope from coefficient to coefficient against the squared misfit, so that
    a spline with close knots neither oscillates nor cuts corners (a P-spline, Eilers and Marx 1996). A straight line
    costs nothing, also at its ends, where the coefficients of clamped knots are closer to each other.
    """
    x, y = np.ascontiguousarray(x, np.float64), np.ascontiguousarray(y, np.float64)
    intervals = max(1, round(float(x[-1] - x[0]) / knot_spacing))
    breaks = np.linspace(x[0], x[-1], intervals + 1)
    knots = np.concatenate([[x[0]] * DEGREE, breaks, [x[-1]] * DEGREE])
    count = intervals + DEGREE
    steps = _greville_steps(knots, count)
    bands, right = normal_equations(x, y, knots, steps, stiffness * len(x) / count)
    line = y[0] + np.concatenate([[0.0], np.cumsum(steps)]) * (y[-1] - y[0]) / (x[-1] - x[0])
    floor = least_slope * (y[-1] - y[0]) / (x[-1] - x[0]) * steps
    return BSpline(knots, _increasing_least_squares(bands, right, line, floor), DEGREE)


def _greville_steps(knots: Floats, count: int) -> Floats:
    """Returns the distances [count - 1] between the Greville abscissae of neighbouring coefficients.

    The coefficients of a straight line rise in proportion to these.
    """
    abscissae = np.mean([knots[first : first + count] for first in range(1, DEGREE + 1)], axis=0)
    return cast(Floats, np.diff(abscissae))


@compiled(nogil=True, error_model="numpy")
def normal_equations(x: Floats, y: Floats, knots: Floats, steps: Floats, stiffness: float) -> tuple[Floats, Floats]:
    """Returns the bands [4, n] (lower form) and the right side [n] of the least-squares problem of n coefficients.

    x, y: [samples], x rising. stiffness: weight of the squared changes of slope between neighbouring pairs of
    coefficients. The sum of these squares stands for the integral of the squared curvature. Where `steps` [n - 1] are
    equal, they are second differences.
    """
    count = len(steps) + 1
    bands, right, basis, before = np.zeros((DEGREE + 1, count)), np.zeros(count), np.empty(4), np.empty(4)
    place = DEGREE
    for sample in range(len(x)):
        while place < count - 1 and x[sample] >= knots[place + 1]:
            place += 1
        basis[0] = 1.0
        for degree in range(1, DEGREE + 1):  # de Boor's recurrence
            before[:degree] = basis[:degree]
            basis[0] = 0.0
            for n in range(1, degree + 1):
                low, high = knots[place + n - degree], knots[place + n]
                part = before[n - 1] / (high - low)
                basis[n - 1] += part * (high - x[sample])
                basis[n] = part * (x[sample] - low)
        for i in range(DEGREE + 1):
            right[place - DEGREE + i] += basis[i] * y[sample]
            for j in range(i + 1):
                bands[i - j, place - DEGREE + j] += basis[i] * basis[j]
    bends, change, widest = np.zeros((DEGREE + 1, count)), np.empty(3), steps.max()
    for k in range(count - 2):
        weight = np.sqrt(2.0 * widest / (steps[k] + steps[k + 1]))
        change[0], change[2] = weight * (widest / steps[k]), weight * (widest / steps[k + 1])
        change[1] = -weight * (widest / steps[k] + widest / steps[k + 1])
        for i in range(3):
            for j in range(i + 1):
                bends[i - j, k + j] += change[i] * change[j]
    return bands + stiffness * bends, right


def _increasing_least_squares(bands: Floats, right: Floats, inside: Floats, floor: Floats) -> Floats:
    """Minimises 1/2 c'Hc - r'c subject to diff(c) >= floor, by a primal-dual interior-point method from `inside`.

    H is given by its bands [4, n] (lower form), r by `right` [n]. Each step solves one banded system, so a step is
    linear in n. The number of steps hardly depends on n.
    """
    c, scale = inside.copy(), float(bands[0].mean())
    bands, right = bands / scale, right / scale
    bands[0] += 1e-9  # keeps coefficients of a stretch without samples in place
    slack = np.diff(c) - floor
    unit = float(slack.mean())
    dual = np.full_like(slack, unit)
    weight, pull = np.empty_like(slack), np.empty_like(slack)
    for _ in range(MOST_STEPS):
        gap = float(slack @ dual) / len(slack)
        system, target, steepest = newton_system(bands, right, c, slack, dual, gap, weight, pull)
        if gap < 1e-10 * unit**2 and steepest < 1e-7 * unit:
            break
        _, move, failed = dpbsv(system, target, lower=1)
        if failed:
            raise LinAlgError("the normal equations of a spline are not positive definite")
        advance(c, slack, dual, floor, move, weight, pull)
    return c


@compiled(nogil=True, error_model="numpy")
def newton_system(
    bands: Floats, right: Floats, c: Floats, slack: Floats, dual: Floats, gap: float, weight: Floats, pull: Floats
) -> tuple[Floats, Floats, float]:
    """Returns the bands [4, n] and the right side [n] of the next step's system, and the largest slope of the problem.

    Fills `weight` and `pull` [n - 1], by which the step moves the dual variables.
    """
    count = len(c)
    system, target, steepest = bands.copy(), np.empty(count), 0.0
    for i in range(count - 1):
        weight[i] = dual[i] / slack[i]
        pull[i] = 0.1 * gap / slack[i] - dual[i]
        system[0, i] += weight[i]
        system[1, i] -= weight[i]
    for i in range(1, count):
        system[0, i] += weight[i - 1]
    for i in range(count):
        slope = bands[0, i] * c[i]
        for offset in range(1, DEGREE + 1):
            if i + offset < count:
                slope += bands[offset, i] * c[i + offset]
            if i >= offset:
                slope += bands[offset, i - offset] * c[i - offset]
        slope -= right[i]
        if i < count - 1:
            slope += dual[i]
        if i > 0:
            slope -= dual[i - 1]
        steepest = max(steepest, abs(slope))
        target[i] = -slope
        if i < count - 1:
            target[i] -= pull[i]
        if i > 0:
            target[i] += pull[i - 1]
    return system, target, steepest


@compiled(nogil=True, error_model="numpy")
def advance(c: Floats, slack: Floats, dual: Floats, floor: Floats, move: Floats, weight: Floats, pull: Floats) -> None:
    """Moves `c` [n], `slack` and `dual` [n - 1] by the step `move` [n], as far as all stay positive."""
    reach, duals = 1.0, np.empty_like(dual)
    for i in range(len(slack)):
        slack_move = move[i + 1] - move[i]
        duals[i] = pull[i] - weight[i] * slack_move
        if slack_move < 0.0:
            reach = min(reach, 0.99 * (-slack[i] / slack_move))
        if duals[i] < 0.0:
            reach = min(reach, 0.99 * (-dual[i] / duals[i]))
    for i in range(len(c)):
        c[i] += reach * move[i]
    for i in range(len(slack)):
        slack[i] = c[i + 1] - c[i] - floor[i]
        dual[i] += reach * duals[i]
