"""Answers that are motion files: BVH, glTF and VRM animations."""

from __future__ import annotations

from collections.abc import Iterator

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import pieces
from motionsplice.motion.formats.files import WRITERS
from motionsplice.motion.roles import Roles
from motionsplice.service.answers.answer import Answer
from motionsplice.service.problems import RequestError
from motionsplice.service.wire.encoding import Encoding

FILES = {  # the media types of motion files, by their suffix
    "bvh": b"application/x-bvh",
    "glb": b"model/gltf-binary",
    "gltf": b"model/gltf+json",
    "vrma": b"model/gltf-binary",
}


def check_encoding(form: str, how: Encoding) -> None:
    """Raises RequestError for an encoding that a file cannot have."""
    if not how.axes.ours or how.parts != "local":
        problem = f"a {form.upper()} file holds local rotations in the axes gltf"
        raise RequestError(problem, mend="Leave out axes and parts")


def written(clip: Clip, roles: Roles, form: str) -> Iterator[bytes]:
    """Yields the file of a motion, in pieces."""
    yield from pieces(clip) if form == "bvh" else [WRITERS[f".{form}"](clip, roles)]


def file_answer(file: bytes, form: str, *names: str | None) -> Answer:
    """Returns the answer with a file that is named after clips."""
    name = "+".join(one for one in names if one)
    safe = "".join(one if one.isascii() and (one.isalnum() or one in "+-_.") else "_" for one in name)
    named = f'attachment; filename="{safe}.{form}"'.encode()
    return Answer(file, FILES[form], headers=[(b"content-disposition", named)])
