"""Makes any file's joints a skeleton whose joint 0 is the papers' root: nodes above the hips are folded into it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError, listed
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers, Skeleton, chain, subtree

STEADY = 0.01  # of the longest bone: an inner joint that moves less on its parent is noise

ROTATION = 32  # bytes
PER_BYTE, FREE = 16, 16 * 2**20  # bytes of rotations: for each of the file, which has 2 for a channel at least; for any


@dataclass(frozen=True, eq=False)
class Nodes:
    """A file's J joints and E end sites over F frames, unchanged, in the file's unit of length.

    names, parents: the joints, parent before child; a root's parent is negative.
    offsets:        [J, 3] from the parent to the joint at rest, in the parent's frame.
    end_parents, end_offsets: [E], [E, 3] the end sites.
    translations:   [F, 3] by joint, from the parent to the joint over time, for joints with position channels.
    rotations:      [F, J, 4] in the parents' frames.
    """

    names: tuple[str, ...]
    parents: Integers
    offsets: Floats
    end_parents: Integers
    end_offsets: Floats
    translations: Mapping[int, Floats]
    rotations: Floats


def still(frames: int, joints: int, size: int) -> Floats:
    """Returns identity rotations [frames, joints, 4], for the channels of a file of `size` bytes to be written into.

    Raises FormatError if the array would be far larger than the file, in which joints without channels take no space.
    """
    if frames * joints * ROTATION > PER_BYTE * size + FREE:
        problem = f"{frames} frames of {joints} joints, most of them without channels, take too much memory"
        raise FormatError(problem + f" for a file of {size} bytes", mend="Remove the joints without channels")
    rotations = np.empty((frames, joints, 4))
    rotations[:] = quaternion.IDENTITY
    return rotations


@dataclass(frozen=True, eq=False)
class Folded:
    """A skeleton and its motion, still in the file's unit, and notes on what was changed."""

    skeleton: Skeleton
    root_positions: Floats
    rotations: Floats
    notes: tuple[str, ...]


def fold(nodes: Nodes, root: int) -> Folded:
    """Makes the joint `root` joint 0 and keeps its descendants only.

    The transforms of its ancestors, moving or not, become part of its world transform. The position channels of an
    inner joint are replaced by their median, as its offset; a note names the joints that move.
    """
    position, rotation = _world(nodes, root)
    inside = subtree(nodes.parents, root)
    places = {joint: place for place, joint in enumerate(inside)}
    offsets, notes, moving = nodes.offsets[inside].copy(), list[str](), list[str]()
    longest = float(np.linalg.norm(nodes.offsets[inside[1:]], axis=1).max(initial=0.0))
    for place, joint in enumerate(inside[1:], 1):
        if joint in nodes.translations:
            moved = nodes.translations[joint]
            offsets[place] = np.median(moved, axis=0)
            if np.abs(moved - offsets[place]).max() > STEADY * longest:
                moving.append(nodes.names[joint])
    if moving:
        notes.append(f"move on their parents, fixed at their median offsets: {listed(moving)}")
    if dropped := [name for joint, name in enumerate(nodes.names) if joint not in places]:
        notes.append(f"{nodes.names[root]!r} is the root; left out: {listed(dropped)}")
    ends = [end for end, joint in enumerate(nodes.end_parents) if int(joint) in places]
    offsets[0] = 0.0
    skeleton = Skeleton(
        names=tuple(nodes.names[joint] for joint in inside),
        parents=np.array([-1] + [places[int(nodes.parents[joint])] for joint in inside[1:]]),
        offsets=offsets,
        end_parents=np.array([places[int(nodes.end_parents[end])] for end in ends], np.int64),
        end_offsets=nodes.end_offsets[ends].reshape(-1, 3),
    )
    # Frame by frame in memory, unlike [:, inside]. A file's whole tree is not copied: nobody else needs its array.
    rotations = nodes.rotations if len(inside) == len(nodes.names) else np.take(nodes.rotations, inside, axis=1)
    rotations[:, 0] = rotation
    return Folded(skeleton, position, rotations, tuple(notes))


def _world(nodes: Nodes, joint: int) -> tuple[Floats, Floats]:
    """Returns a joint's world position [F, 3] and rotation [F, 4]."""
    frames = len(nodes.rotations)
    position, rotation = np.zeros((frames, 3)), np.tile(quaternion.IDENTITY, (frames, 1))
    for link in reversed(chain(nodes.parents, joint)):
        local = nodes.translations.get(link, np.broadcast_to(nodes.offsets[link], (frames, 3)))
        position = position + quaternion.rotate(rotation, local)
        rotation = quaternion.multiply(rotation, nodes.rotations[:, link])
    return position, rotation
