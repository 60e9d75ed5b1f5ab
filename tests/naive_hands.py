"""Slow, readable twins of the kernels that align hands to a body."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.motion.skeleton import Integers
from motionsplice.precompute.hands.costs import WINDOW
from motionsplice.precompute.hands.phases import derivatives
from motionsplice.precompute.hands.points import HandMotion

UP = [0.0, 1.0, 0.0]


def turn(body: HandMotion, hands: HandMotion, i: int, j: int) -> Floats:
    """The turn about Y that aligns a window of the hands to a window of the body (equation 7), by search."""

    def window(points: Floats, at: int) -> Floats:
        frames = np.clip(np.arange(at - WINDOW // 2, at + WINDOW // 2 + 1), 0, len(points) - 1)
        cloud = points[frames].reshape(-1, 3) * [1.0, 0.0, 1.0]
        return np.asarray(cloud - cloud.mean(axis=0))

    ours, theirs = window(body.points, i), window(hands.points, j)
    angles = np.linspace(-np.pi, np.pi, 7201)
    apart = [np.sum((ours - Rotation.from_rotvec(np.array(UP) * angle).apply(theirs)) ** 2) for angle in angles]
    return about(UP, angles[int(np.argmin(apart))])


def sign(values: Floats, zone: float) -> Floats:
    return np.where(np.abs(values) > zone, np.sign(values), 0.0)


def phase_cost(body: HandMotion, hands: HandMotion, rate: float, i: int, j: int, turned: Floats) -> float:
    """Equation 6: the squared difference of the signs of both derivatives, summed over all points."""
    ours, theirs = derivatives(body.points, rate), derivatives(hands.points, rate)
    cost = 0.0
    for point in range(4):
        for a, b, zone, their_zone in (
            (ours.velocity, theirs.velocity, ours.still, theirs.still),
            (ours.acceleration, theirs.acceleration, ours.steady, theirs.steady),
        ):
            derivative = rotate(turned, b[j, point])
            cost += float(np.sum((sign(a[i, point], zone) - sign(derivative, their_zone)) ** 2))
    return cost


def pace_cost(body: HandMotion, hands: HandMotion, rate: float, i: int, j: int, turned: Floats) -> float:
    """The squared difference of both derivatives, each divided by its clip's deviation, summed over all points."""
    ours, theirs = derivatives(body.points, rate), derivatives(hands.points, rate)
    cost = 0.0
    for point in range(4):
        for a, b in ((ours.velocity, theirs.velocity), (ours.acceleration, theirs.acceleration)):
            apart = a[i, point] / a.std() - rotate(turned, b[j, point]) / b.std()
            cost += float(np.sum(apart**2))
    return cost


def palm_cost(body: HandMotion, hands: HandMotion, i: int, j: int, turned: Floats) -> float:
    """Equation 9: the angle between both hands once the forearms are aligned by the least turn."""

    def bones(points: Floats) -> tuple[Floats, Floats]:
        wrist = 0.5 * (points[0] + points[1])
        forearm, hand = points[2] - wrist, points[3] - wrist
        return forearm / np.linalg.norm(forearm), hand / np.linalg.norm(hand)

    (f, h), (g, k) = bones(body.points[i]), bones(rotate(turned, hands.points[j]))
    axis, cosine = np.cross(g, f), float(g @ f)
    aligned = k
    if np.linalg.norm(axis) > 1e-12:
        angle = np.arctan2(np.linalg.norm(axis), cosine)
        aligned = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).apply(k)
    return float(np.arccos(np.clip(h @ aligned, -1.0, 1.0)))


def path_cost(costs: Floats, low: Integers, high: Integers) -> float:
    """The least cost of a monotone path through a band (equations 1 to 3), by a full matrix, infinite outside it."""
    columns = int(high.max()) + 1
    whole = np.full((len(costs), columns), np.inf)
    for i, row in enumerate(costs):
        whole[i, low[i] : high[i] + 1] = row[: high[i] - low[i] + 1]
    total = np.full((len(costs) + 1, columns + 1), np.inf)
    total[0, low[0]] = 0.0
    for i in range(len(costs)):
        for j in range(columns):
            total[i + 1, j + 1] = whole[i, j] + min(total[i, j], total[i, j + 1], total[i + 1, j])
    return float(total[-1, int(high[-1]) + 1])
