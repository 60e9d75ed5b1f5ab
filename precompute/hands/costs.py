"""Costs of matching two frames of a hand: by the phase of the gesture, its pace, and the palm's orientation.

Majkowska, Zordan and Faloutsos 2006, 4, equations 6 to 9, computed over the cells of a band.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers
from motionsplice.precompute.hands.banded_warp import Band
from motionsplice.precompute.hands.phases import Derivatives, derivatives
from motionsplice.precompute.hands.points import HandMotion, bones
from motionsplice.runtime.simd.compiled import FASTMATH

WINDOW = 5  # frames that one turn is fitted to
Costs = NDArray[np.float32]


class Comparison:
    """Compares one hand of a body with the same hand of a hands clip, both at `rate` frames per second.

    In each cell the hand of the hands clip is turned about Y onto the body's: by the best fit of a window of frames, in
    closed form (equation 7), or by the headings of the trunks. Raises SettingsError if these are unknown.
    """

    def __init__(self, body: HandMotion, hands: HandMotion, rate: float, *, by_trunk: bool = False) -> None:
        self._body, self._hands = body, hands
        self._changes = derivatives(body.points, rate), derivatives(hands.points, rate)
        ours, theirs = (_headings(one) if by_trunk else _windows(one.points) for one in (body, hands))
        half = theirs.shape[1] // 2
        self._facing = ours, theirs, np.concatenate([theirs[:, half:], -theirs[:, :half]], axis=1)

    def phases(self, band: Band) -> Costs:
        """Returns equation 6 in each cell of a band [F, width]: by how much the signs of both derivatives differ."""
        costs = np.zeros((len(band.low), band.width), np.float32)
        ours, theirs = self._changes
        for change, their_change, zone, their_zone in (
            (ours.velocity, theirs.velocity, ours.still, theirs.still),
            (ours.acceleration, theirs.acceleration, ours.steady, theirs.steady),
        ):
            signs = np.where(np.abs(change) > zone, np.sign(change), 0.0)
            _add_differences(signs, their_change / their_zone, True, *self._facing, band.low, band.high, costs)
        return costs

    def paces(self, band: Band) -> Costs:
        """Returns the squared difference of both derivatives of all points, in each cell of a band [F, width].

        Each derivative is in units of its spread in its clip. This distinguishes frames within one phase, where signs
        are alike and palms may be.
        """
        costs = np.zeros((len(band.low), band.width), np.float32)
        ours, theirs = (_paces(found) for found in self._changes)
        _add_differences(ours, theirs, False, *self._facing, band.low, band.high, costs)
        return costs

    def palms(self, band: Band) -> Costs:
        """Returns equation 9 in each cell of a band [F, width]: radians between both hands, with forearms aligned."""
        costs = np.zeros((len(band.low), band.width), np.float32)
        ours, theirs = bones(self._body.points), bones(self._hands.points)
        _add_palm_costs(ours, theirs, *self._facing, band.low, band.high, costs)
        return costs


def _headings(motion: HandMotion) -> Floats:
    """Returns the heading of the trunk as a window of one point ahead of it [F, 2]."""
    if motion.trunk is None:
        mend = "Give its angles, or turn the hands by a window of frames"
        raise SettingsError("the heading of the trunk is unknown", mend=mend)
    return np.stack([np.sin(motion.trunk), np.cos(motion.trunk)], axis=1)


def _windows(points: Floats) -> Floats:
    """Returns the points of WINDOW frames about each frame, centred, as x and then z coordinates [F, n]."""
    frames = np.arange(len(points))[:, None] + np.arange(WINDOW) - WINDOW // 2
    around = points[np.clip(frames, 0, len(points) - 1)].reshape(len(points), -1, 3)
    centred = around - around.mean(axis=1, keepdims=True)
    return np.concatenate([centred[:, :, 0], centred[:, :, 2]], axis=1)


def _paces(found: Derivatives) -> Floats:
    """Returns both derivatives [F, 8, 3] in units of their spread, or of the dead zone in a clip at rest."""
    parts = (found.velocity, found.still), (found.acceleration, found.steady)
    return np.concatenate([change / max(float(change.std()), zone) for change, zone in parts], axis=1)


@compiled(nogil=True, fastmath=FASTMATH)
def _turn(body: Floats, hands: Floats, turned: Floats, i: int, j: int) -> tuple[float, float]:
    """Returns cosine and sine of the turn about Y that lays the hands in frame j onto the body's in frame i."""
    along = across = 0.0
    for k in range(body.shape[1]):
        along += body[i, k] * hands[j, k]
        across += body[i, k] * turned[j, k]
    size = math.sqrt(along * along + across * across)
    return (along / size, across / size) if size > 0.0 else (1.0, 0.0)


@compiled(nogil=True)
def _sign(value: float) -> float:
    """Returns the sign of a value in units of its dead zone: 0 inside it."""
    return 1.0 if value > 1.0 else -1.0 if value < -1.0 else 0.0


@compiled(nogil=True, fastmath=FASTMATH)
def _add_differences(
    ours: Floats,
    theirs: Floats,
    signs: bool,
    body: Floats,
    hands: Floats,
    turned: Floats,
    low: Integers,
    high: Integers,
    out: Costs,
) -> None:
    """Adds the squared differences of vectors [F, n, 3] to `out`, after turning theirs onto ours.

    signs: compare ours with the signs of theirs, which are then given in units of their dead zone.
    """
    for i in range(len(low)):
        for j in range(low[i], high[i] + 1):
            cosine, sine = _turn(body, hands, turned, i, j)
            cost = 0.0
            for k in range(ours.shape[1]):
                x, y, z = theirs[j, k, 0], theirs[j, k, 1], theirs[j, k, 2]
                x, z = cosine * x + sine * z, cosine * z - sine * x
                if signs:
                    x, y, z = _sign(x), _sign(y), _sign(z)
                dx, dy, dz = ours[i, k, 0] - x, ours[i, k, 1] - y, ours[i, k, 2] - z
                cost += dx * dx + dy * dy + dz * dz
            out[i, j - low[i]] += cost


@compiled(nogil=True)
def _turned(cosine: float, sine: float, bone: Floats) -> tuple[float, float, float]:
    """Returns a vector [3] turned about Y."""
    return cosine * bone[0] + sine * bone[2], bone[1], cosine * bone[2] - sine * bone[0]


@compiled(nogil=True)
def _add_palm_costs(
    ours: Floats,
    theirs: Floats,
    body: Floats,
    hands: Floats,
    turned: Floats,
    low: Integers,
    high: Integers,
    out: Costs,
) -> None:
    """Adds the angles between ours and theirs [F, 2, 3] (forearm, hand) to `out`, radians, with forearms aligned."""
    for i in range(len(low)):
        (fx, fy, fz), (px, py, pz) = ours[i, 0], ours[i, 1]
        for j in range(low[i], high[i] + 1):
            cosine, sine = _turn(body, hands, turned, i, j)
            gx, gy, gz = _turned(cosine, sine, theirs[j, 0])
            hx, hy, hz = _turned(cosine, sine, theirs[j, 1])
            # the least turn from g to f takes h to h + v x h + v x (v x h) / (1 + g f), with v = g x f
            vx, vy, vz = gy * fz - gz * fy, gz * fx - gx * fz, gx * fy - gy * fx
            near = max(1.0 + gx * fx + gy * fy + gz * fz, 1e-6)
            ux, uy, uz = vy * hz - vz * hy, vz * hx - vx * hz, vx * hy - vy * hx
            wx, wy, wz = vy * uz - vz * uy, vz * ux - vx * uz, vx * uy - vy * ux
            overlap = px * (hx + ux + wx / near) + py * (hy + uy + wy / near) + pz * (hz + uz + wz / near)
            out[i, j - low[i]] += math.acos(min(max(overlap, -1.0), 1.0))
