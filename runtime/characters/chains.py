"""The chains of joints that turn toward a target: trunk, neck and arms, and where they point by themselves."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.errors import BankError
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import common_ancestor
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import REBUILD
from motionsplice.runtime.simd.compiled import Array

TRUNK, LEFT_ARM, RIGHT_ARM, NECK = range(4)
FORWARD = [0.0, 0.0, 1.0]
# where a left arm is free to move, 40 degrees outward and down from ahead; no captured arm comes within 70 degrees of
# the opposite direction
DOWN = OUTWARD = math.radians(40.0)
REST = [math.cos(DOWN) * math.sin(OUTWARD), -math.sin(DOWN), math.cos(DOWN) * math.cos(OUTWARD)]


class Chains(NamedTuple):
    """Four chains: the trunk from the root to the joint where the arms branch, both arms, and neck with head.

    Attributes:
        lengths: [4], number of joints of each chain.
        firsts: [4], the first joint of the trunk that turns; the shoulder of each arm; for the neck, the joint of the
            trunk on which it hangs.
        columns: [4, longest], the first column of each joint in a pose.
        offsets: [4, longest, 3], of each joint from its parent, metres.
        gaze: [3], where the head points in its own frame, on average of the baseline's stride: ahead.
        eyes: [3], the head in the frame of the joint on which the neck hangs, on average of the same stride, metres.
        shoulders: [3], the middle of the shoulders in the frame of the last joint of the trunk, likewise.
        rests: [3, 3], of each arm, a direction about which it is free to move, in the frame of the last joint of the
            trunk, likewise; of the trunk, zeros.
        world: [joints of the trunk, 11], scratch memory: rotation, place, and by how much the rotation was turned.
    """

    lengths: Annotated[Array, np.int64, 1]
    firsts: Annotated[Array, np.int64, 1]
    columns: Annotated[Array, np.uint64, 2]
    offsets: Annotated[Array, np.float64, 3]
    gaze: Annotated[Array, np.float64, 1]
    eyes: Annotated[Array, np.float64, 1]
    shoulders: Annotated[Array, np.float64, 1]
    rests: Annotated[Array, np.float64, 2]
    world: Annotated[Array, np.float64, 2]


def chains_of(bank: Bank) -> Chains:
    """Returns the chains of a bank's rig. Without neck and head, the chain NECK is empty.

    Raises BankError if a joint of the trunk or of an arm is not below the one that it should hang on.
    """
    skeleton, roles = bank.skeleton, bank.roles
    chest = common_ancestor(skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    arms = (roles.left_wrist, roles.left_shoulder), (roles.right_wrist, roles.right_shoulder)
    hangs = all(upper in skeleton.chain(lower) for lower, upper in ((chest, roles.pelvis), *arms))
    if not hangs or any(shoulder == chest for _, shoulder in arms):
        raise BankError("the joints of its roles are not those of a body", file=str(bank.path), mend=REBUILD)
    trunk = skeleton.chain(chest)[::-1]
    head = next(joint for joint in (roles.head, roles.neck, chest) if joint >= 0)
    neck = skeleton.chain(head)[::-1]
    branch = max(at for at, joint in enumerate(trunk) if joint in neck)
    parts = [
        trunk,
        below(skeleton.chain(roles.left_wrist), chest),
        below(skeleton.chain(roles.right_wrist), chest),
        neck[branch + 1 :],
    ]
    longest = max(len(part) for part in parts)
    columns, offsets = np.zeros((4, longest), np.uint64), np.zeros((4, longest, 3))
    for number, part in enumerate(parts):
        columns[number, : len(part)] = [4 * joint for joint in part]
        offsets[number, : len(part)] = skeleton.offsets[part]
    shoulders = parts[LEFT_ARM].index(roles.left_shoulder), parts[RIGHT_ARM].index(roles.right_shoulder)
    return Chains(
        np.array([len(part) for part in parts]),
        np.array([trunk.index(roles.pelvis), *shoulders, branch]),
        columns,
        offsets,
        *neutral(bank, trunk[branch], chest, head),
        np.zeros((len(trunk), 11)),
    )


def below(chain: list[int], joint: int) -> list[int]:
    """Returns the joints of a chain, which goes up, that are below a joint of it, from there down."""
    return chain[: chain.index(joint)][::-1]


def neutral(bank: Bank, branch: int, chest: int, head: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Returns gaze, eyes, shoulders and rests of `Chains`, as means over the baseline's stride.

    They come from motion, not from the bind pose: an angle of the head in the bind pose, or local axes that are not
    those of the world, do not matter.
    """
    clip, roles = bank.motion(bank.baseline.clip), bank.roles
    first = min(round(bank.baseline.start * clip.rate), clip.frame_count - 1)
    stride = slice(first, max(round(bank.baseline.end * clip.rate), first + 1))
    positions, world = world_transforms(bank.skeleton, clip.root_positions[stride], clip.rotations[stride])
    headings = quaternion.about([0.0, 1.0, 0.0], bank.root_path(clip.name)[stride, 3])
    ahead = quaternion.rotate(headings, FORWARD)
    left, right = (quaternion.rotate(headings, rest) for rest in (REST, np.multiply(REST, [-1.0, 1.0, 1.0])))
    middle = 0.5 * (positions[:, roles.left_shoulder] + positions[:, roles.right_shoulder])
    return (
        quaternion.unit(in_frame(world[:, head], ahead)),
        in_frame(world[:, branch], positions[:, head] - positions[:, branch]),
        in_frame(world[:, chest], middle - positions[:, chest]),
        np.array([np.zeros(3), *(quaternion.unit(in_frame(world[:, chest], rest)) for rest in (left, right))]),
    )


def in_frame(frames: Floats, vectors: Floats) -> NDArray[np.float64]:
    """Returns the mean [3] of vectors [F, 3] of the world, in frames [F, 4]."""
    return np.asarray(quaternion.rotate(quaternion.conjugate(frames), vectors).mean(axis=0))
