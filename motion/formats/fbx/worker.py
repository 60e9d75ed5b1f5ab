"""The child process that reads one FBX file with ufbx: a script of its own, without NumPy and the rest of the package.

Standard input is a line of JSON, then the file. Standard output is a line of JSON, then doubles: a result that goes
through a pipe leaves no file behind, however the process ends.

The bindings of ufbx 0.0.5 free memory that is still in use when a wrapper is dropped. So `keep` holds every wrapper
until the process ends, and the process ends without cleaning up.
"""

from __future__ import annotations

import json
import os
import sys
from array import array
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import count, pairwise
from typing import Any, BinaryIO, TypeVar

FEWEST_KEYS = 4  # that show a rate
SLOWEST, FASTEST = 5.0, 240.0  # frames per second: other rates are not believed
USUAL_RATE = 30.0
ON_FRAME = 0.02  # frames: a key lies on a frame if it is at most this far from it
NUDGE = 1e-9  # seconds after its time at which a frame is sampled: a stepped key at that time has then begun

Answer = tuple[dict[str, Any], "list[array[float]]"]
Wrapper = TypeVar("Wrapper")
_kept: list[object] = []


def keep(wrapper: Wrapper) -> Wrapper:
    _kept.append(wrapper)
    return wrapper


def each(wrappers: Iterable[Any]) -> Iterator[Any]:
    """Yields the items of a ufbx list, and keeps them and the list."""
    return map(keep, keep(wrappers))


def main(source: BinaryIO, target: BinaryIO) -> None:
    request = json.loads(source.readline())
    limit_memory(request["memory"])
    try:
        import ufbx

        answer, numbers = read(ufbx, source.read(), **request["options"])
    except MemoryError:
        answer, numbers = {"problem": "it takes too much memory", "mend": "Export the armature without meshes"}, []
    except RefusedError as error:
        answer, numbers = {"problem": error.problem, "mend": error.mend}, []
    target.write(json.dumps(answer).encode() + b"\n")
    for values in numbers:
        target.write(values)
    target.flush()


def limit_memory(size: int) -> None:
    """Lets this process take `size` bytes more than it has, and turns off core dumps, where the system can do so."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with open("/proc/self/statm", "rb") as counts:
            size += int(counts.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (size, size))


class RefusedError(Exception):
    """A file that cannot be read, in words for the user."""

    def __init__(self, problem: str, mend: str) -> None:
        self.problem, self.mend = problem, mend


def read(ufbx: Any, data: bytes, names_only: bool, animation: str | None, most: int) -> Answer:
    """Returns the names of a file's animations, and the motion of the one named `animation`, or of the only one.

    If there is no such animation, or `names_only` is true, it returns the names alone. A file without animations gives
    one frame at rest. Raises RefusedError, also for a motion of more than `most` transforms.
    """
    scene = load(ufbx, data)
    tree = Tree(ufbx, scene)
    stacks = animations(scene, {tree.nodes[node].element_id for node in tree.kept})
    answer: dict[str, Any] = {"animations": list(stacks)}
    if animation is None and len(stacks) == 1:
        (animation,) = stacks
    chosen = None if animation is None else stacks.get(animation)
    if names_only or (stacks and chosen is None):
        return answer, []
    settings = keep(scene.settings)
    anim = None if chosen is None else keep(chosen[0].anim)
    times, rate = ([0.0], USUAL_RATE) if chosen is None else frames_of(*chosen, settings, len(tree.kept), most)
    places, nodes = {node: place for place, node in enumerate(tree.kept)}, [tree.nodes[node] for node in tree.kept]
    bound = {places[node]: matrix for node, matrix in tree.bind_pose(scene).items() if node in places}
    bind, rest, moved = array("d"), array("d"), array("d")
    for matrix in bound.values():
        extend(bind, matrix)
    for node in nodes:
        extend(rest, node.local_transform)
    for time in times:
        for node in nodes:
            extend(moved, ufbx.evaluate_transform(anim, node, time) if anim else node.local_transform)
    answer |= {
        "names": [node.name for node in nodes],
        "parents": [places.get(tree.parents[node], -1) for node in tree.kept],
        "joints": [node in tree.joints for node in tree.kept],
        "left_out": tree.left_out,
        "unit": settings.unit_meters,
        "bound": list(bound),
        "rate": rate,
        "frames": len(times),
    }
    return answer, [bind, rest, moved]


def load(ufbx: Any, data: bytes) -> Any:
    """Returns the scene of a file, with Y up. Raises RefusedError, MemoryError."""
    try:
        return keep(
            ufbx.load_memory(
                data,
                file_format=ufbx.FileFormat.FBX,
                ignore_geometry=True,
                ignore_embedded=True,
                target_axes=ufbx.axes_right_handed_y_up,
                space_conversion=ufbx.SpaceConversion.ADJUST_TRANSFORMS,
                # However a node inherits scale, its world transform is then its parent's times its local one.
                inherit_mode_handling=ufbx.InheritModeHandling.COMPENSATE,
            )
        )
    except (ufbx.OutOfMemoryError, ufbx.MemoryLimitError):
        raise MemoryError from None
    except ufbx.UfbxError as error:
        problem = f"not an FBX file, or a damaged one ({error})"
        raise RefusedError(problem, "Export it again as FBX 2014 or newer") from None


def frames_of(stack: Any, keys: list[float], settings: Any, nodes: int, most: int) -> tuple[list[float], float]:
    """Returns the times of a stack's frames, in seconds, and their rate.

    Raises RefusedError if these frames of all nodes are more than `most` transforms.
    """
    begin, end = stack.time_begin, stack.time_end
    if end <= begin:
        begin, end = min(keys), max(keys)
    rate = rate_of(keys, begin, settings.frames_per_second)
    frames = 1 + round(min((end - begin) * rate, most))
    if frames * nodes > most:
        problem = f"{end - begin:g} s of {nodes} nodes at {rate:g} frames per second take too much memory"
        raise RefusedError(problem, "Cut the animation into shorter ones")
    return [min(begin + frame / rate + NUDGE, end) for frame in range(frames)], rate


def extend(numbers: array[float], vectors: Iterable[Iterable[float]]) -> None:
    for vector in vectors:
        numbers.extend(vector)


class Tree:
    """The nodes of a scene, parent before child; the first is the scene's root.

    nodes: all of them. parents: by node. joints: which nodes are joints. kept: the joints and the nodes above them,
    depth first. left_out: the names of the others.
    """

    def __init__(self, ufbx: Any, scene: Any) -> None:
        kinds = ufbx.ElementType
        self.nodes = list(each(scene.nodes))
        above = [keep(node.parent) for node in self.nodes]
        self.parents = [-1 if parent is None else parent.typed_id for parent in above]
        of_kind: dict[int, set[int]] = {}
        for node in self.nodes:
            of_kind.setdefault(node.attrib_type, set()).add(self.owner(node))
        bones = {self.owner(bone) for cluster in each(scene.skin_clusters) if (bone := keep(cluster.bone_node))}
        bones |= of_kind.get(kinds.BONE, set())
        self.joints = bones or (of_kind.get(kinds.EMPTY, set()) | of_kind.get(kinds.UNKNOWN, set()))
        needed = set(self.joints)
        for at in range(len(self.nodes) - 1, 0, -1):
            if at in needed:
                needed.add(self.parents[at])
        self.kept = [at for at in self.in_depth() if at in needed]
        # The cameras that every file has are not worth a note.
        system = of_kind.get(kinds.CAMERA_SWITCHER, set()) | {
            at for at in of_kind.get(kinds.CAMERA, set()) if self.nodes[at].name.startswith("Producer ")
        }
        others = set(map(self.owner, self.nodes)) - needed - system - {0}
        self.left_out = [self.nodes[at].name for at in sorted(others)]

    def in_depth(self) -> Iterator[int]:
        """Yields the nodes below the root depth first, as other formats order joints."""
        below: list[list[int]] = [[] for _ in self.nodes]
        for at in range(len(self.nodes) - 1, 0, -1):
            below[self.parents[at]].append(at)
        waiting = list(below[0])
        while waiting:
            yield (at := waiting.pop())
            waiting.extend(below[at])

    def owner(self, node: Any) -> int:
        """Returns the place of a node, or of its parent if ufbx added the node to hold that parent's attribute.

        It does so where a scale applies to the attribute but not to the children.
        """
        return self.parents[node.typed_id] if node.is_scale_helper else node.typed_id

    def bind_pose(self, scene: Any) -> dict[int, Any]:
        """Returns the world matrices that skins state by node, or else those of bind poses."""
        found = {}
        for pose in each(scene.poses):
            if pose.is_bind_pose:
                for bone in each(pose.bone_poses):
                    found[self.owner(keep(bone.bone_node))] = bone.bone_to_world
        for cluster in each(scene.skin_clusters):
            if bone := keep(cluster.bone_node):
                found[self.owner(bone)] = cluster.bind_to_world
        return found


def animations(scene: Any, moved: set[int]) -> dict[str, tuple[Any, list[float]]]:
    """Returns the animation stacks by name, each with the key times of its most densely keyed curve.

    Only curves of the elements `moved` count; stacks without them are left out. A stack without a name is called by its
    number, and a second "Take" becomes "Take.001".
    """
    found: dict[str, tuple[Any, list[float]]] = {}
    for number, stack in enumerate(each(scene.anim_stacks)):
        most: list[float] = []
        for layer in each(stack.layers):
            for moving in each(layer.anim_props):
                if keep(moving.element).element_id in moved:
                    for curve in map(keep, keep(moving.anim_value).curves):
                        if curve is not None and len(keys := keep(curve.keyframes)) > len(most):
                            most = [key.time for key in keys]
        if most:
            name = free = stack.name or str(number)
            numbers = count(1)
            while free in found:
                free = f"{name}.{next(numbers):03d}"
            found[free] = stack, most
    return found


def rate_of(keys: list[float], begin: float, stated: float) -> float:
    """Returns the stated frame rate if the keys lie on its frames or show no rate of their own, else the keys' rate."""
    if not SLOWEST <= stated <= FASTEST:
        stated = USUAL_RATE
    if len(keys) < FEWEST_KEYS or lie_on_frames(keys, begin, stated):
        return stated
    steps = sorted(after - before for before, after in pairwise(keys))
    own = round(1.0 / max(steps[len(steps) // 2], 1e-6), 6)
    return own if SLOWEST <= own <= FASTEST and lie_on_frames(keys, keys[0], own) else stated


def lie_on_frames(keys: list[float], begin: float, rate: float) -> bool:
    """Returns whether at least nine in ten keys lie on frames."""
    frames = [(key - begin) * rate for key in keys]
    return sum(abs(frame - round(frame)) > ON_FRAME for frame in frames) <= len(frames) // 10


if __name__ == "__main__":
    sys.path.append(sys.argv[1])  # where the parent found ufbx
    main(sys.stdin.buffer, sys.stdout.buffer)
    os._exit(0)
