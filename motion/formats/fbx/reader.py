"""Reads the nodes and animations of an FBX file as scenes, in a child process."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from motionsplice.motion.errors import FormatError, listed
from motionsplice.motion.formats.scene import Scene, most_transforms, unknown_animation
from motionsplice.motion.formats.transforms import in_the_world, local_transforms
from motionsplice.motion.quaternion import Floats

WORKER = Path(__file__).with_name("worker.py")
SECONDS, SECONDS_PER_BYTE = 20.0, 1e-5  # limits of a child: far more than it needs, since the machine may be busy
MEMORY, MEMORY_PER_BYTE = 64 * 2**20, 64  # bytes that a child may take beside what Python takes
STACK = (b"\0\1AnimStack", b'"AnimStack::')  # follows the name of a stack in binary files, precedes it in text
EXPORT = "Export it again as FBX 2014 or newer"


def animation_names(data: bytes) -> list[str]:
    """Returns the names of the animations that move joints, or [] for a file that has only one. Raises FormatError.

    A file that evidently has only one is not parsed, which would take a child process.
    """
    if sum(data.count(mark) for mark in STACK) == 1:
        return []
    return list(_ask(data, names_only=True, animation=None)[0]["animations"])


def read_scene(data: bytes, animation: str | None, *, still: bool = False) -> Scene:
    """Reads the joints of a file and the nodes above them, moved by one of its animations, or by its only one.

    If `still`, a file without animations gives one frame at rest. Raises FormatError.
    """
    answer, numbers = _ask(data, names_only=False, animation=animation)
    names = answer["animations"]
    if not names and not still:
        raise FormatError("it has no animation that moves a joint", mend="Export the armature with its animation")
    if "frames" not in answer:
        raise unknown_animation(animation, names)
    return _scene(answer, numbers)


def _ask(data: bytes, **options: Any) -> tuple[dict[str, Any], Floats]:
    """Returns what a child process finds in a file: a document, and numbers. Raises FormatError."""
    found = find_spec("ufbx")
    if found is None or found.origin is None:
        raise FormatError("FBX files need the package ufbx", mend="Run: pip install 'motionsplice[fbx]'")
    options["most"] = most_transforms(len(data))
    request = {"memory": MEMORY + MEMORY_PER_BYTE * len(data), "options": options}
    seconds = SECONDS + SECONDS_PER_BYTE * len(data)
    # -I and -S: the user's settings and other packages are not imported, which would take time and might print.
    command = [sys.executable, "-I", "-S", str(WORKER), str(Path(found.origin).parents[1])]
    try:
        sent = json.dumps(request).encode() + b"\n" + data
        child = subprocess.run(command, input=sent, capture_output=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        raise FormatError(f"reading it takes more than {seconds:.3g} s", mend=EXPORT) from None
    except OSError as error:
        problem = f"the process that reads FBX files cannot be started: {error.strerror}"
        raise FormatError(problem, mend="Try again when the machine has more memory") from None
    if child.returncode < 0:
        raise FormatError(f"reading it ended with signal {-child.returncode}", mend=EXPORT)
    if child.returncode > 0:
        last = child.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise FormatError(f"reading it failed: {last[:200] or f'exit code {child.returncode}'}", mend=EXPORT)
    head, _, numbers = child.stdout.partition(b"\n")
    answer = json.loads(head)
    if "problem" in answer:
        raise FormatError(answer["problem"], mend=answer["mend"])
    return answer, np.frombuffer(numbers)


def _scene(answer: dict[str, Any], numbers: Floats) -> Scene:
    count, frames, bound = len(answer["names"]), answer["frames"], answer["bound"]
    parents = np.array(answer["parents"], np.int64)
    bind, rest, moved = np.split(numbers, np.cumsum([12 * len(bound), 10 * count]))
    stated = dict(zip(bound, bind.reshape(-1, 4, 3).transpose(0, 2, 1)[..., None], strict=True))
    unstated = parents.copy()
    unstated[bound] = -1
    at_rest = (stated.get(node, local) for node, local in enumerate(_locals(rest.reshape(1, count, 10))))
    notes = [f"left out, not joints: {listed(answer['left_out'])}"] if answer["left_out"] else []
    return Scene(
        names=tuple(name or f"node {place}" for place, name in enumerate(answer["names"])),
        parents=parents,
        joints=np.array(answer["joints"], np.bool_),
        bind=in_the_world(at_rest, unstated, 1)[0],
        world=in_the_world(_locals(moved.reshape(frames, count, 10)), parents, frames),
        rate=answer["rate"],
        roles={},
        unit=answer["unit"],
        notes=tuple(notes),
        bound=bool(bound),
    )


def _locals(values: Floats) -> Iterator[Floats]:
    """Yields each node's transforms to its parent [3, 4, F], from translations, rotations and scales [F, N, 10]."""
    for node in range(values.shape[1]):
        yield local_transforms(*np.split(values[:, node], (3, 7), axis=1))
