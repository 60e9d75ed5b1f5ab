"""Forward kinematics of eight characters at once."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.kernels.rotations import product, rotated
from motionsplice.runtime.simd.compiled import Array, kernel
from motionsplice.runtime.simd.handle import Handle, record_at
from motionsplice.runtime.simd.lanes import gather, load, scatter, spread, store
from motionsplice.runtime.simd.width import LANES

# columns of scratch memory: world rotation and world position of a joint, each in eight lanes
X, Y, Z, W, AT_X, AT_Y, AT_Z, COLUMNS = (np.uint64(LANES * number) for number in range(8))


class RigArrays(NamedTuple):
    """A skeleton of J joints as flat arrays, for forward kinematics, and scratch memory for eight characters."""

    parents: Annotated[Array, np.int64, 1]  # [J]
    offsets: Annotated[Array, np.float32, 2]  # [J, 3]
    world: Annotated[Array, np.float32, 2]  # [J, COLUMNS]


def rig_arrays(skeleton: Skeleton) -> RigArrays:
    """Returns a skeleton as flat arrays."""
    world = np.zeros((skeleton.joint_count, int(COLUMNS)), np.float32)
    return RigArrays(skeleton.parents, skeleton.offsets.astype(np.float32), world)


@kernel
def world_positions(handle: Handle, roots: Array, rotations: Array, positions: Array) -> None:
    """Writes world positions [n, 3 J] of poses: roots [n, 3] and rotations [n, 4 J]. handle is that of RigArrays."""
    rig = record_at(handle, RigArrays)
    world, last = rig.world, len(roots) - 1
    for first in range(0, len(roots), LANES):
        for k in range(LANES):
            for axis in range(3):
                world[0, int(AT_X) + LANES * axis + k] = roots[min(first + k, last), axis]
        for joint in range(len(rig.parents)):
            x, y, z, w = gather(rotations, first, last, 4 * joint)
            above = max(rig.parents[joint], 0)
            ax, ay, az = load(world, above, AT_X), load(world, above, AT_Y), load(world, above, AT_Z)
            if joint > 0:
                px, py, pz, pw = (
                    load(world, above, X),
                    load(world, above, Y),
                    load(world, above, Z),
                    load(world, above, W),
                )
                dx, dy, dz = rig.offsets[joint, 0], rig.offsets[joint, 1], rig.offsets[joint, 2]
                ox, oy, oz = rotated(px, py, pz, pw, spread(dx), spread(dy), spread(dz))
                ax, ay, az = ax + ox, ay + oy, az + oz
                x, y, z, w = product(px, py, pz, pw, x, y, z, w)
            store(world, joint, X, x)
            store(world, joint, Y, y)
            store(world, joint, Z, z)
            store(world, joint, W, w)
            store(world, joint, AT_X, ax)
            store(world, joint, AT_Y, ay)
            store(world, joint, AT_Z, az)
            scatter(positions, first, last, 3 * joint, ax, ay, az)
