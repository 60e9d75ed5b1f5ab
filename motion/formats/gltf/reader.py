"""Reads the nodes and animations of a glTF 2.0 file as scenes."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from typing import Any
from urllib.parse import unquote

import numpy as np

from motionsplice.motion.errors import FormatError
from motionsplice.motion.formats.gltf.accessors import read_accessor
from motionsplice.motion.formats.gltf.container import EXPORT, Container, open_container, read_document
from motionsplice.motion.formats.gltf.humanoid import human_bones, humanoid_nodes
from motionsplice.motion.formats.gltf.tracks import Track, key_rate
from motionsplice.motion.formats.names import numbered
from motionsplice.motion.formats.scene import Scene, most_transforms, unknown_animation
from motionsplice.motion.formats.transforms import in_the_world, local_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers

PATHS = {"translation": 3, "rotation": 4, "scale": 3}
DEFAULTS = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0, 1.0, 1.0)}
MALFORMED = (
    *(KeyError, IndexError, TypeError, ValueError, AttributeError, RecursionError, OverflowError, struct.error),
)
MOST_NUMBERS = 1_000_000  # in the tracks of a small file, whose accessors may all lie over the same bytes
Tracks = dict[tuple[int, str], Track]


def animation_names(data: bytes) -> list[str]:
    """Returns the names of a file's animations; those without a name are called by their number. Raises FormatError."""
    with malformed():
        return _names(read_document(data)[0])


def read_scene(
    data: bytes, read_beside: Callable[[str], bytes], animation: str | None, *, still: bool = False
) -> Scene:
    """Reads the nodes of a file, moved by one of its animations, or by its only one, at the rate of its keys.

    `read_beside` reads a file in the same folder, for buffers. If `still`, a file without animations gives one frame at
    rest. Raises FormatError.
    """
    with malformed():
        container = open_container(data, read_beside)
        names = _names(container.document)
        if not names and still:
            return _rest(container)[0]
        if not names:
            raise FormatError("it has no animation", mend="Export the armature with its animation")
        if animation is None and len(names) == 1:
            (animation,) = names
        if animation not in names:
            raise unknown_animation(animation, names)
        return _scene(container, names.index(animation))


def read_rest(data: bytes) -> tuple[Scene, list[int]]:
    """Reads the nodes of a GLB file at rest, as one frame, and the number of each in the file. Raises FormatError."""
    with malformed():
        return _rest(open_container(data, _not_beside))


def _rest(container: Container) -> tuple[Scene, list[int]]:
    order, parents = _order(container.document["nodes"])
    return _posed(container, order, parents, {}, np.zeros(1), 1.0), order


def _not_beside(name: str) -> bytes:
    raise FormatError(f"its data are in another file, {name!r}", mend="Export it as one GLB file")


def buffer_files(data: bytes) -> list[str]:
    """Returns the names of the files beside it that hold its buffers. Raises FormatError."""
    with malformed():
        uris = [buffer.get("uri") for buffer in read_document(data)[0].get("buffers", ())]
        return [unquote(uri) for uri in uris if uri is not None and not uri.startswith("data:")]


@contextmanager
def malformed() -> Iterator[None]:
    """Turns the errors that malformed JSON leads to into a FormatError."""
    try:
        yield
    except MALFORMED as error:
        problem = f"the file is malformed: {type(error).__name__} {str(error)[:80]}"
        raise FormatError(problem, mend=EXPORT) from None


def _names(document: dict[str, Any]) -> list[str]:
    animations = enumerate(document.get("animations", ()))
    return list(numbered([_text(animation.get("name") or number) for number, animation in animations]))


def _text(name: Any) -> str:
    """Returns a name as text that can be written: JSON may hold half a character."""
    return str(name).encode(errors="replace").decode()


def _scene(container: Container, number: int) -> Scene:
    document = container.document
    order, parents = _order(document["nodes"])
    tracks = _tracks(container, document["animations"][number], len(order))
    if not tracks:
        raise FormatError("this animation moves no node", mend="Choose another one, or bake it before the export")
    times, rate = _times(list(tracks.values()), len(order), most_transforms(container.size))
    return _posed(container, order, parents, tracks, times, rate)


def _posed(
    container: Container, order: list[int], parents: Integers, tracks: Tracks, times: Floats, rate: float
) -> Scene:
    document, nodes = container.document, container.document["nodes"]
    still = _at_rest([nodes[node] for node in order])
    rest = in_the_world(still, parents, 1)[0]
    locals_ = (_moved(nodes[node], node, tracks, times, local) for node, local in zip(order, still, strict=True))
    world = in_the_world(locals_, parents, len(times))
    places = {node: place for place, node in enumerate(order)}
    roles = humanoid_nodes(document)
    joints, bind = _skeleton(container, places, parents, rest)
    joints[[places[node] for node in human_bones(document).values()]] = True
    if not joints.any():
        joints[[places[node] for node, _ in tracks]] = True
    names = tuple(_text(nodes[node].get("name") or f"node {node}") for node in order)
    named = {role: names[places[node]] for role, node in roles.items()}
    bound = any("inverseBindMatrices" in skin for skin in document.get("skins", ()))
    return Scene(names, parents, joints, bind, world, rate, named, bound=bound)


def _order(nodes: list[dict[str, Any]]) -> tuple[list[int], Integers]:
    """Returns the nodes parent before child, and for each in this order the place of its parent, or -1."""
    above = {}
    for node, one in enumerate(nodes):
        for child in one.get("children", ()):
            if not 0 <= child < len(nodes) or child in above:
                problem = f"its child {child} is not a node, or has another parent"
                raise FormatError(problem, place=f"node {node}", mend=EXPORT)
            above[child] = node
    waiting = [node for node in range(len(nodes) - 1, -1, -1) if node not in above]
    order, places = list[int](), dict[int, int]()
    while waiting:
        node = waiting.pop()
        places[node] = len(order)
        order.append(node)
        waiting.extend(reversed(nodes[node].get("children", ())))
    if len(order) < len(nodes):
        raise FormatError("its nodes form a cycle", mend=EXPORT)
    return order, np.array([places[above[node]] if node in above else -1 for node in order])


def _tracks(container: Container, animation: dict[str, Any], count: int) -> Tracks:
    tracks: Tracks = {}
    read = cache(partial(read_accessor, container))  # channels share their times
    left = max(MOST_NUMBERS, container.size)
    for channel in animation["channels"]:
        node, path = channel["target"].get("node"), channel["target"]["path"]
        if node is None or path not in PATHS:
            continue  # an extension's target, or weights of morph targets
        if not 0 <= node < count:
            raise FormatError(f"an animation moves node {node} of {count}", mend=EXPORT)
        sampler = animation["samplers"][channel["sampler"]]
        times, values = read(sampler["input"])[:, 0], read(sampler["output"])
        left -= values.size
        if left < 0:
            raise FormatError("its accessors share their bytes and take too much memory", mend=EXPORT)
        if values.shape[1] != PATHS[path]:
            raise FormatError(f"a {path} has {values.shape[1]} numbers, expected {PATHS[path]}", mend=EXPORT)
        tracks[node, path] = Track(times, values, sampler.get("interpolation", "LINEAR"), path == "rotation")
    return tracks


def _times(tracks: list[Track], nodes: int, most: int) -> tuple[Floats, float]:
    """Returns the times [F] of frames from the first key to the last, and their rate; `most` transforms in all."""
    rate = key_rate(tracks)
    first = min(float(track.times[0]) for track in tracks)
    last = max(float(track.times[-1]) for track in tracks)
    frames = round((last - first) * rate) + 1
    if frames * nodes > most:
        problem = f"{last - first:g} s of {nodes} nodes at {rate:g} frames per second take too much memory"
        raise FormatError(problem, mend="Cut the animation into shorter ones")
    return first + np.arange(frames) / rate, rate


def _at_rest(nodes: list[dict[str, Any]]) -> list[Floats]:
    """Returns the transforms of nodes at rest to their parents, each [3, 4, 1]."""
    parts = (
        np.array([node.get(path, DEFAULTS[path]) for node in nodes], np.float64).reshape(len(nodes), width)
        for path, width in PATHS.items()
    )
    locals_ = local_transforms(*parts)
    return [
        np.array(node["matrix"], np.float64).reshape(4, 4).T[:3, :, None] if "matrix" in node else locals_[..., [place]]
        for place, node in enumerate(nodes)
    ]


def _moved(node: dict[str, Any], number: int, tracks: Tracks, times: Floats, rest: Floats) -> Floats:
    """Returns a node's transforms to its parent [3, 4, F], or `rest` if no track moves it."""
    moved = {path: tracks[number, path].sampled(times) for path in PATHS if (number, path) in tracks}
    if not moved:
        return rest
    values = {
        path: moved.get(path, np.array([node.get(path, DEFAULTS[path])], np.float64)) for path in PATHS
    }  # [F or 1, width]
    return local_transforms(values["translation"], values["rotation"], values["scale"])


def _skeleton(container: Container, places: dict[int, int], parents: Integers, rest: Floats) -> tuple[Any, Floats]:
    """Returns which nodes are joints of a skin, and the bind pose of all nodes [N, 3, 4].

    A node's bind pose is its inverse bind matrix inverted, if a skin has one, else its transform at rest. Exporters
    state bind matrices in the space of the mesh or of the armature; the one in which most joints are at rest is taken.
    """
    joints, bind = np.zeros(len(places), np.bool_), rest.copy()
    for skin in container.document.get("skins", ()):
        own = [places[node] for node in skin["joints"]]
        joints[own] = True
        if "inverseBindMatrices" in skin:
            inverse = read_accessor(container, skin["inverseBindMatrices"])
            if inverse.shape != (len(own), 16):
                raise FormatError(f"{len(own)} joints have {len(inverse)} inverse bind matrices", mend=EXPORT)
            stated = np.asarray(np.linalg.inv(inverse.reshape(-1, 4, 4).transpose(0, 2, 1)), np.float64)
            top = min(own)  # parents come before children
            bind[own] = _in_the_world(stated, rest[own], rest[parents[top]] if parents[top] >= 0 else None)
    return joints, bind


def _in_the_world(stated: Floats, rest: Floats, armature: Floats | None) -> Floats:
    """Returns stated bind transforms [J, 4, 4] in the world [J, 3, 4], given the joints' and the armature's at rest."""
    spaces = [np.eye(4)]
    if armature is not None:
        spaces.append(np.concatenate([armature, [[0.0, 0.0, 0.0, 1.0]]]))
    found = [(space @ stated)[:, :3] for space in spaces]
    off = [float(np.median(np.abs(one - rest).max(axis=(1, 2)) / (1e-9 + np.abs(rest).max()))) for one in found]
    return found[int(np.argmin(off))]
