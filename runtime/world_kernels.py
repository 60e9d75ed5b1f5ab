"""Forward kinematics across a block of characters; as in `runtime.kernels`, nothing here checks or allocates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from runtime.arrays import BLOCK, Array, RigArrays
from runtime.compiled import kernel
from runtime.rotation_kernels import product, rotated

# rows of a joint in the scratch: its rotation and its position in the world
X, Y, Z, W, AT, JOINT_ROWS = 0, 1, 2, 3, 4, 7


def scratch(joints: int) -> NDArray[np.float32]:
    """Room for a block of characters; the first two of its joints are the parent and the joint at hand, so that the
    compiler knows how far apart they are."""
    return np.zeros((joints + 2) * JOINT_ROWS * BLOCK, np.float32)


@kernel
def world_positions(rig: RigArrays, roots: Array, rotations: Array, world: Array, positions: Array) -> None:
    """Writes world positions [n, 3 J] of poses, roots [n, 3] and rotations [n, 4 J]; world is `scratch`."""
    joints, rows = len(rig.parents), JOINT_ROWS * BLOCK
    for first in range(0, len(roots), BLOCK):
        count = min(BLOCK, len(roots) - first)
        for joint in range(joints):
            for k in range(count):
                for i in range(4):
                    world[rows + i * BLOCK + k] = rotations[first + k, 4 * joint + i]
            if joint == 0:
                for k in range(count):
                    for axis in range(3):
                        world[rows + (AT + axis) * BLOCK + k] = roots[first + k, axis]
            else:
                above = (rig.parents[joint] + 2) * rows
                for i in range(rows):
                    world[i] = world[above + i]
                follow(world, rig.offsets[joint, 0], rig.offsets[joint, 1], rig.offsets[joint, 2])
            here = (joint + 2) * rows
            for i in range(rows):
                world[here + i] = world[rows + i]
            for k in range(count):
                for axis in range(3):
                    positions[first + k, 3 * joint + axis] = world[rows + (AT + axis) * BLOCK + k]


@kernel
def follow(world: Array, dx: float, dy: float, dz: float) -> None:
    """A joint's place and rotation in the world from its parent's, its offset and its own rotation."""
    own, at = JOINT_ROWS * BLOCK, AT * BLOCK
    for k in range(BLOCK):
        x, y, z, w = world[k], world[BLOCK + k], world[2 * BLOCK + k], world[3 * BLOCK + k]
        px, py, pz = rotated(x, y, z, w, dx, dy, dz)
        world[own + at + k] = world[at + k] + px
        world[own + at + BLOCK + k] = world[at + BLOCK + k] + py
        world[own + at + 2 * BLOCK + k] = world[at + 2 * BLOCK + k] + pz
        x, y, z, w = product(
            x,
            y,
            z,
            w,
            world[own + k],
            world[own + BLOCK + k],
            world[own + 2 * BLOCK + k],
            world[own + 3 * BLOCK + k],
        )
        world[own + k], world[own + BLOCK + k] = x, y
        world[own + 2 * BLOCK + k], world[own + 3 * BLOCK + k] = z, w
