"""From what a file holds (any rig, any node above the hips) to a skeleton whose joint 0 is the papers' root."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers, Skeleton, chain, subtree

STEADY = 0.01  # of the rig's longest bone: less movement of an inner joint on its parent is noise

STILL = 10_000_000  # rotations that any file may have, however few of them it holds


@dataclass(frozen=True, eq=False)
class Nodes:
    """A file's joints as they stand in it, in the file's unit of length.

    names, parents: J joints, parent before child.
    offsets:        [J, 3] each joint's place on its parent at rest.
    end_parents, end_offsets: [E], [E, 3] the end sites.
    translations:   by joint, [F, 3], its place on its parent over time, for joints that have position channels.
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
    """Joints that do not turn [frames, joints, 4], for a file of `size` bytes to fill in.

    Raises FormatError if they would take far more memory than the file: joints without channels cost it nothing.
    """
    if frames * joints > max(STILL, size):
        problem = f"{frames} frames of {joints} joints, most of which do not move, are too many"
        raise FormatError(problem, mend="Leave out the joints without channels")
    return np.tile(quaternion.IDENTITY, (frames, joints, 1))


@dataclass(frozen=True, eq=False)
class Folded:
    """A skeleton and its motion, still in the file's unit, and what was changed on the way."""

    skeleton: Skeleton
    root_positions: Floats
    rotations: Floats
    notes: tuple[str, ...]


def fold(nodes: Nodes, root: int) -> Folded:
    """Makes the joint `root` joint 0: all above it, moving or not, becomes its world transform; the rest is dropped.

    An inner joint's position channels become its offset: their median, which is noted if they move.
    """
    position, rotation = _world(nodes, root)
    kept = subtree(nodes.parents, root)
    places = {joint: place for place, joint in enumerate(kept)}
    offsets, notes = nodes.offsets[kept].copy(), []
    longest = float(np.linalg.norm(nodes.offsets[kept[1:]], axis=1).max(initial=0.0))
    for place, joint in enumerate(kept[1:], 1):
        if joint in nodes.translations:
            moved = nodes.translations[joint]
            offsets[place] = np.median(moved, axis=0)
            if np.abs(moved - offsets[place]).max() > STEADY * longest:
                notes.append(f"joint {nodes.names[joint]!r} moves on its parent; it was fixed at its median place")
    if dropped := [name for joint, name in enumerate(nodes.names) if joint not in places]:
        notes.append(
            f"{nodes.names[root]!r} is the root; left out: {', '.join(dropped[:5])}{' ...' * (len(dropped) > 5)}"
        )
    ends = [end for end, joint in enumerate(nodes.end_parents) if int(joint) in places]
    offsets[0] = 0.0
    skeleton = Skeleton(
        names=tuple(nodes.names[joint] for joint in kept),
        parents=np.array([-1] + [places[int(nodes.parents[joint])] for joint in kept[1:]]),
        offsets=offsets,
        end_parents=np.array([places[int(nodes.end_parents[end])] for end in ends], np.int64),
        end_offsets=nodes.end_offsets[ends].reshape(-1, 3),
    )
    rotations = nodes.rotations[:, kept]
    rotations[:, 0] = rotation
    return Folded(skeleton, position, rotations, tuple(notes))


def _world(nodes: Nodes, joint: int) -> tuple[Floats, Floats]:
    """A joint's world position [F, 3] and rotation [F, 4]."""
    frames = len(nodes.rotations)
    position, rotation = np.zeros((frames, 3)), np.tile(quaternion.IDENTITY, (frames, 1))
    for one in reversed(chain(nodes.parents, joint)):
        local = nodes.translations.get(one, np.broadcast_to(nodes.offsets[one], (frames, 3)))
        position = position + quaternion.rotate(rotation, local)
        rotation = quaternion.multiply(rotation, nodes.rotations[:, one])
    return position, rotation
