"""A scene of moving nodes, as glTF and FBX files hold it, and the joints in it as the project's `Nodes`.

In those files a joint's local axes are whatever the exporter chose. Here each joint's axes become those of the world in
the bind pose, so that the bind pose has no rotations, as in a BVH file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError, did_you_mean, listed
from motionsplice.motion.formats.fold import Nodes
from motionsplice.motion.formats.names import numbered
from motionsplice.motion.formats.transforms import rotations_of
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers

END = re.compile(r"(_end|[_ .]?End|Nub|_leaf|HeadTop_End)(\d*|_\d+)$")  # leaves that mark the tip of a bone
SMALLEST_BODY = 13  # joints: a root, and three in each limb; a smaller skeleton is a prop
STEADY = 1e-4  # of the longest bone: a joint that moves less on its parent does not move
MOST_TRANSFORMS = 300_000  # nodes times frames of any file: keys far apart, and nodes without keys, take no bytes
BYTES = 4  # that each further transform takes in a file: a key takes 16 bytes, and some nodes have none
BLOCK = 8192  # transforms that are worked on at once: few enough for the processor's cache


@dataclass(frozen=True, eq=False)
class Scene:
    """N nodes over F frames.

    names: [N]; parents: [N], parent before child, -1 for those at the top.
    joints: [N] whether a node is a joint of a body rather than a mesh, a camera or a prop.
    bind, world: [N, 3, 4] and [F, N, 3, 4] transforms to the world, in the bind pose and over time. The first three
    columns are the axes, with their scale, and the last is the position.
    roles: names of nodes by role, if the file states them. notes: what was left out or assumed. unit: metres in a unit.
    bound: whether the file states a bind pose; if not, `bind` is the pose of the nodes at rest.
    """

    names: tuple[str, ...]
    parents: Integers
    joints: NDArray[np.bool_]
    bind: Floats
    world: Floats
    rate: float
    roles: Mapping[str, str]
    notes: tuple[str, ...] = ()
    unit: float = 1.0
    bound: bool = True


def unknown_animation(animation: str | None, names: Sequence[str]) -> FormatError:
    """Returns the error for a name that is none of a file's animations, or for no name where there are several."""
    if animation is None:
        return FormatError(f"it has {len(names)} animations", mend=f"Choose one with --animation: {', '.join(names)}")
    return FormatError(f"it has no animation {animation!r}", mend=did_you_mean(animation, names))


def most_transforms(size: int) -> int:
    """Returns the most transforms, nodes times frames, that a file of `size` bytes may have."""
    return MOST_TRANSFORMS + size // BYTES


def nodes_of(scene: Scene, root: str | None = None) -> tuple[Nodes, tuple[str, ...]]:
    """Makes the joints of one skeleton of a scene `Nodes`, and returns notes for the user.

    It is the skeleton with the joint `root`, else the largest. Joints are kept with all nodes between them. Transforms
    above them become part of the root's. Raises FormatError if there are no joints, or none called `root`.
    """
    inside, ends, dropped, others = joints_of(scene, root)
    places = {node: place for place, node in enumerate(inside)}
    parents = np.array([places.get(int(scene.parents[node]), -1) for node in inside])
    world, local = _turns(scene, inside, parents)
    at, rest = scene.world[..., 3][:, inside], scene.bind[inside][..., 3]
    offsets = np.concatenate([np.zeros((1, 3)), rest[1:] - rest[parents[1:]]])
    end_parents = np.array([places[int(scene.parents[node])] for node in ends], np.int64)
    nodes = Nodes(
        names=numbered([scene.names[node] for node in inside]),
        parents=parents,
        offsets=offsets,
        end_parents=end_parents,
        end_offsets=(scene.bind[ends][..., 3] - rest[end_parents]).reshape(-1, 3),
        translations=_translations(at, world, parents, offsets),
        rotations=local,
    )
    notes = [*scene.notes, *others]
    if dropped:
        notes.append(f"left out, not part of the skeleton: {listed(dropped)}")
    return nodes, tuple(notes)


def _turns(scene: Scene, inside: list[int], parents: Integers) -> tuple[Floats, Floats]:
    """Returns the rotations since the bind pose, of joints to the world [J, F, 4] and to their parents [F, J, 4]."""
    unbound = quaternion.conjugate(rotations_of(scene.bind[inside]))[:, None]
    frames = len(scene.world)
    world, local = np.empty((len(inside), frames, 4)), np.empty((frames, len(inside), 4))
    by_node, above = scene.world.transpose(1, 2, 3, 0), np.maximum(parents, 0)
    step = max(1, BLOCK // frames)
    for block in (slice(first, first + step) for first in range(0, len(inside), step)):
        turned = rotations_of(np.moveaxis(by_node[inside[block]], 3, 1))
        world[block] = quaternion.multiply(turned, unbound[block])
        turns = quaternion.multiply(quaternion.conjugate(world[above[block]]), world[block])
        local[:, block] = quaternion.one_hemisphere(turns.swapaxes(0, 1))
    local[:, 0] = quaternion.one_hemisphere(world[0])  # the root has no parent
    return world, local


def joints_of(scene: Scene, root: str | None = None) -> tuple[list[int], list[int], list[str], list[str]]:
    """Returns the joints of one skeleton, parent before child, its end sites, joints beside it, and a note on others.

    It is the skeleton with the joint `root`, else the largest. Raises FormatError if there are no joints, or none
    called `root`.
    """
    kept, dropped, others = _body(scene, root)
    ends = _ends(scene, kept)
    return sorted(set(kept) - set(ends)), ends, dropped, others


def _body(scene: Scene, root: str | None) -> tuple[list[int], list[str], list[str]]:
    """Returns the nodes of one skeleton, parent before child, the names of joints beside it, and a note on others."""
    if not scene.joints.any():
        raise FormatError("no skeleton found", mend="Export the armature with the animation")
    top = np.full(len(scene.names), -1)  # the highest joint above each node, or the node itself
    for node, parent in enumerate(scene.parents.tolist()):
        above = top[parent] if parent >= 0 else -1
        top[node] = above if above >= 0 or not scene.joints[node] else node
    sizes, names = np.bincount(top[scene.joints]), numbered(scene.names)
    chosen = int(np.argmax(sizes))
    if root is not None:
        if root not in names or top[names.index(root)] < 0:
            found = [names[node] for node in np.flatnonzero(sizes)]
            raise FormatError(f"no skeleton has a joint {root!r}", mend=f"Choose one with --root: {', '.join(found)}")
        chosen = int(top[names.index(root)])
    inside = top == chosen
    needed = scene.joints & inside
    for node in range(len(needed) - 1, -1, -1):
        parent = scene.parents[node]
        if needed[node] and parent >= 0 and inside[parent]:
            needed[parent] = True
    bodies = [node for node in np.flatnonzero(sizes >= SMALLEST_BODY).tolist() if node != chosen]
    dropped = [names[joint] for joint in np.flatnonzero(scene.joints & ~needed) if top[joint] not in bodies]
    others = listed([names[node] for node in bodies])
    note = f"read the skeleton {names[chosen]!r}; choose another with --root: {others}"
    return np.flatnonzero(needed).tolist(), dropped, [note] if others else []


def _ends(scene: Scene, kept: list[int]) -> list[int]:
    """Returns the nodes that only mark the tip of a joint; a skin may list them as joints or not."""
    parents, joints = set(scene.parents.tolist()), set(kept)
    tips = [node for node, name in enumerate(scene.names) if node not in parents and END.search(name)]
    return [node for node in tips if int(scene.parents[node]) in joints]


def _translations(at: Floats, world: Floats, parents: Integers, offsets: Floats) -> dict[int, Floats]:
    """The root's path, and the joints that move on their parents, as seen from these; `world` [J, F, 4] turns."""
    longest = float(np.linalg.norm(offsets[1:], axis=1).max(initial=0.0))
    found = {0: at[:, 0]}
    for joint in range(1, len(parents)):
        parent = int(parents[joint])
        moved = quaternion.rotate(quaternion.conjugate(world[parent]), at[:, joint] - at[:, parent])
        if np.abs(moved - offsets[joint]).max() > STEADY * longest:
            found[joint] = moved
    return found
