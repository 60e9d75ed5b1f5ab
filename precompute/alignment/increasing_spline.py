"""A strictly increasing cubic B-spline through a time alignment, in time linear in its length.

Heck et al. 2006, 3.1: "we fit a strictly increasing, endpoint interpolating B-spline to the optimal path". The spline's
ends are its first and last coefficients. Here they are fitted like all others, since a path's ends are only whole
frames. A B-spline with strictly increasing coefficients is strictly increasing. So the fit is a least-squares problem
in which each coefficient must lie a little above the previous one: a quadratic programme with banded matrices.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded
from scipy.sparse import csr_array, diags_array

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
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    intervals = max(1, round(float(x[-1] - x[0]) / knot_spacing))
    breaks = np.linspace(x[0], x[-1], intervals + 1)
    knots = np.concatenate([[x[0]] * DEGREE, breaks, [x[-1]] * DEGREE])
    design = BSpline.design_matrix(x, knots, DEGREE).tocsr()
    count = intervals + DEGREE
    steps = _greville_steps(knots, count)
    bend = _slope_changes(steps)
    normal = csr_array(design.T @ design + stiffness * len(x) / count * (bend.T @ bend))
    bands = np.zeros((DEGREE + 1, count))
    for offset in range(DEGREE + 1):
        bands[offset, : count - offset] = normal.diagonal(offset)
    line = y[0] + np.concatenate([[0.0], np.cumsum(steps)]) * (y[-1] - y[0]) / (x[-1] - x[0])
    floor = least_slope * (y[-1] - y[0]) / (x[-1] - x[0]) * steps
    coefficients = _increasing_least_squares(bands, design.T @ y, line, floor)
    return BSpline(knots, coefficients, DEGREE)


def _greville_steps(knots: Floats, count: int) -> Floats:
    """Returns the distances [count - 1] between the Greville abscissae of neighbouring coefficients.

    The coefficients of a straight line rise in proportion to these.
    """
    abscissae = np.mean([knots[first : first + count] for first in range(1, DEGREE + 1)], axis=0)
    return cast(Floats, np.diff(abscissae))


def _slope_changes(steps: Floats) -> csr_array:
    """Returns the matrix [n - 2, n] of changes of slope between neighbouring pairs of n coefficients.

    The sum of their squares stands for the integral of the squared curvature. Where steps are equal, they are second
    differences.
    """
    slopes = steps.max() / steps
    weights = np.sqrt(2.0 * steps.max() / (steps[:-1] + steps[1:]))
    diagonals = [weights * slopes[:-1], -weights * (slopes[:-1] + slopes[1:]), weights * slopes[1:]]
    return csr_array(diags_array(diagonals, offsets=[0, 1, 2], shape=(len(steps) - 1, len(steps) + 1)))


def _increasing_least_squares(bands: Floats, right: Floats, inside: Floats, floor: Floats) -> Floats:
    """Minimises 1/2 c'Hc - r'c subject to diff(c) >= floor, by a primal-dual interior-point method from `inside`.

    H is given by its bands [4, n] (lower form), r by `right` [n]. Each step solves one banded system, so a step is
    linear in n. The number of steps hardly depends on n.
    """
    c = inside
    scale = float(bands[0].mean())
    bands, right = bands / scale, right / scale
    bands[0] += 1e-9  # keeps coefficients of a stretch without samples in place
    slack = np.diff(c) - floor
    unit = float(slack.mean())
    dual = np.full_like(slack, unit)
    for _ in range(MOST_STEPS):
        gap = float(slack @ dual) / len(slack)
        gradient = _banded_product(bands, c) - right
        gradient[:-1] += dual
        gradient[1:] -= dual
        if gap < 1e-10 * unit**2 and np.abs(gradient).max() < 1e-7 * unit:
            break
        weight = dual / slack
        pull = 0.1 * gap / slack - dual
        system, target = bands.copy(), -gradient
        system[0, :-1] += weight
        system[0, 1:] += weight
        system[1, :-1] -= weight
        target[:-1] -= pull
        target[1:] += pull
        move = solveh_banded(system, target, lower=True)
        slack_move = np.diff(move)
        dual_move = pull - weight * slack_move
        reach = min(_reach(slack, slack_move), _reach(dual, dual_move))
        c = c + reach * move
        slack = np.diff(c) - floor
        dual = dual + reach * dual_move
    return c


def _reach(values: Floats, move: Floats) -> float:
    """Returns the largest part of `move`, at most 1, that keeps `values` positive."""
    shrinking = move < 0.0
    return min(1.0, 0.99 * float(np.min(-values[shrinking] / move[shrinking], initial=np.inf)))


def _banded_product(bands: Floats, c: Floats) -> Floats:
    product: Floats = bands[0] * c
    for offset in range(1, DEGREE + 1):
        band = bands[offset, : len(c) - offset]
        product[:-offset] += band * c[offset:]
        product[offset:] += band * c[:-offset]
    return product
