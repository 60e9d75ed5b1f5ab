"""Mixes sampled halves, and clouds, by weight.

Each half that is mixed, a source, has four rows of `Mixing.planes`, x to w, and a row of `Mixing.lane_weights`. So all
sources are mixed in one pass.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters.arrays import Mixing
from motionsplice.runtime.format.rows import CLOUD, SIZE
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import between_rows
from motionsplice.runtime.kernels.mirror import point_between
from motionsplice.runtime.kernels.posture import mixed
from motionsplice.runtime.kernels.rotations import FOUR, ONE, store_planes
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel
from motionsplice.runtime.simd.lanes import interleave, load, root, separate, signed, spread, store
from motionsplice.runtime.simd.width import LANES


@inlined
def set_lane_weights(mixing: Mixing, source: int, width: Index, weight: Real) -> None:
    """Sets the same weight of a source for all lanes."""
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        store(mixing.lane_weights, source, lane, spread(weight))


@inlined
def split_lanes(lanes: Array, first: Index, width: Index, mixing: Mixing, source: int) -> None:
    """Makes the rotations in lanes from `first` on a source."""
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        x, y, z, w = separate(lanes, first + FOUR * lane)
        store_planes(mixing.planes, plane_of(source), lane, x, y, z, w)


@inlined
def mix_lanes(mixing: Mixing, count: int, width: Index, out: Array, first: Index) -> None:
    """Mixes `count` sources into `out` from `first` on, each along the shorter arc from the sum of those before it."""
    weights, planes = mixing.lane_weights, mixing.planes
    one, least = spread(np.float32(1.0)), spread(np.float32(1e-30))
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        weight = load(weights, 0, lane)
        x, y, z, w = load_planes(planes, np.uint64(0), lane)
        sx, sy, sz, sw = weight * x, weight * y, weight * z, weight * w
        for source in range(1, count):
            x, y, z, w = load_planes(planes, plane_of(source), lane)
            weight = signed(load(weights, source, lane), (sx * x + sy * y) + (sz * z + sw * w))
            sx, sy, sz, sw = sx + weight * x, sy + weight * y, sz + weight * z, sw + weight * w
        scale = one / root(least + ((sx * sx + sy * sy) + (sz * sz + sw * sw)))
        interleave(out, first + FOUR * lane, sx * scale, sy * scale, sz * scale, sw * scale)


@inlined
def load_planes(planes: Array, plane: Index, lane: Index) -> tuple[Array, Array, Array, Array]:
    """Loads eight rotations from four rows from `plane` on, at the column `lane`."""
    x, y = load(planes, plane, lane), load(planes, plane + ONE, lane)
    return x, y, load(planes, plane + ONE + ONE, lane), load(planes, plane + ONE + ONE + ONE, lane)


@inlined
def plane_of(source: int) -> np.uint64:
    """Returns the first row of a source in `Mixing.planes`."""
    return FOUR * np.uint64(source)


@inlined
def rotation_of(mixing: Mixing, source: int, lane: Index) -> tuple[Real, Real, Real, Real]:
    """Returns a rotation of a source."""
    planes, plane = mixing.planes, plane_of(source)
    x, y = planes[plane, lane], planes[plane + ONE, lane]
    return x, y, planes[plane + ONE + ONE, lane], planes[plane + ONE + ONE + ONE, lane]


@inlined
def copy_to_lanes(mixing: Mixing, source: int, lane: Index, lanes: Array, first: Index) -> None:
    """Copies a rotation of a source into lanes, whose first lane is at `first`."""
    at = first + FOUR * lane
    lanes[at], lanes[at + ONE], lanes[at + ONE + ONE], lanes[at + ONE + ONE + ONE] = rotation_of(mixing, source, lane)


@inlined
def set_rotation(mixing: Mixing, source: int, lane: Index, rotation: tuple[Real, Real, Real, Real]) -> None:
    """Replaces a rotation of a source."""
    planes, plane = mixing.planes, plane_of(source)
    planes[plane, lane], planes[plane + ONE, lane] = rotation[0], rotation[1]
    planes[plane + ONE + ONE, lane], planes[plane + ONE + ONE + ONE, lane] = rotation[2], rotation[3]


@inlined
def add_cloud(bank: BankArrays, row: Index, t: Real, weight: Real, mirrored: bool, total: Array, new: bool) -> None:
    """Adds the weighted cloud and size of a row of `lower` to `total`, a row of the same layout; starts it if `new`."""
    size = weight * between_rows(bank.lower, row, np.uint64(SIZE), t)
    total[0, SIZE] = size if new else total[0, SIZE] + size
    if mirrored:
        add_mirrored_cloud(bank, row, t, weight, total, new)
        return
    for column in range(
        np.uint64(CLOUD), np.uint64(CLOUD) + np.uint64(3) * bank.rig[arrays.CLOUD_WIDTH], np.uint64(LANES)
    ):
        value = spread(weight) * mixed(bank.lower, row, column, t)
        store(total, 0, column, value if new else value + load(total, 0, column))


@kernel
def add_mirrored_cloud(bank: BankArrays, row: Index, t: Real, weight: Real, total: Array, new: bool) -> None:
    """Adds the mirror image of the weighted cloud of a row of `lower` to `total`."""
    width = bank.rig[arrays.CLOUD_WIDTH]
    for point in range(bank.rig[arrays.POINTS]):
        column = np.uint64(CLOUD) + np.uint64(point)
        for value in point_between(bank, bank.lower, row, t, np.uint64(point), True):
            total[0, column] = weight * value if new else total[0, column] + weight * value
            column += width
