"""The rig of a client's character in the body of a take, and the take as the motion of that rig's nodes."""

from __future__ import annotations

import base64
import binascii
import re
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats.character import Character, parse_character
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.service.problems import LimitError, RequestError, RigError, TooLargeError
from motionsplice.service.wire.encoding import Arrays

KEY = re.compile(rb'"rig"\s*:\s*"([A-Za-z0-9+/=\\]*)"')  # some write / as \/
MOST_NODES = 2000
MOST_TRANSFORMS = 1_000_000  # joints times frames: 130 MiB
STILL = 1e-6  # a rotation or translation whose numbers change less, relative to the largest, does not change


def without_rig(body: bytes) -> tuple[bytes, bytes | None]:
    """Returns a JSON body whose value of `rig` is empty, and that value, in base64; None if there is none.

    So the rest can have a limit of its own before it is parsed.
    """
    found = KEY.search(body)
    if found is None:
        return body, None
    return body[: found.start(1)] + body[found.end(1) :], found[1].replace(b"\\/", b"/")


def room_for_rig(most: int) -> int:
    """Returns the bytes that a rig of `most` bytes takes in base64, every / written as two."""
    return 2 * 4 * (most // 3 + 1)


def decoded(text: bytes, most: int) -> bytes:
    """Returns the bytes of a rig. Raises RequestError if the text is not base64, TooLargeError above `most` bytes."""
    if len(text) > 4 * (most // 3 + 1):
        raise TooLargeError(f"rig: more than {most} bytes", mend="Leave out meshes, images and animations")
    try:
        return base64.b64decode(text, validate=True)
    except binascii.Error:
        raise RequestError("rig: this is not base64", mend="Send the bytes of a GLB file in base64") from None


@dataclass(frozen=True, eq=False)
class OnRig:
    """A clip on a character's skeleton.

    scale: metres in a unit of the character's file, where its legs are as long as those of the bank's skeleton.
    notes: on what the skeleton does not show.
    """

    character: Character
    clip: Clip
    scale: float
    notes: tuple[str, ...]

    @classmethod
    def of(cls, data: bytes, clip: Clip, roles: Roles) -> Self:
        """Puts a clip on the rig in a GLB file. Raises RigError or LimitError.

        It takes time in proportion to the frames and the joints, so it belongs into a thread.
        """
        from motionsplice.motion.retarget.onto_rig import onto_rig  # SciPy's optimisation takes a while to import
        from motionsplice.motion.retarget.rig import Rig

        try:
            character = parse_character(data, MOST_NODES)
            skeleton = character.skeleton
            if clip.frame_count * skeleton.joint_count > MOST_TRANSFORMS:
                problem = f"rig: {clip.frame_count} frames of {skeleton.joint_count} joints are more than"
                raise LimitError(f"{problem} {MOST_TRANSFORMS} transforms", mend="Ask for fewer frames")
            leg = character.roles.leg_length(skeleton)
            if leg <= 0.0:
                raise FormatError("its legs have no length")
            fitted = onto_rig(clip, roles, Rig(skeleton, character.roles))
        except LimitError:
            raise
        except MotionError as error:
            raise RigError(error.problem, place="rig", mend=error.mend) from None
        return cls(character, fitted.clip, roles.leg_length(clip.skeleton) / leg, fitted.notes)

    def file(self) -> bytes:
        """Returns the rig as a GLB file with the animation."""
        return self.character.animated(self.clip)

    def message(self) -> tuple[dict[str, Any], Arrays]:
        """Returns the fields and the arrays of the nodes' keys, as docs/protocol.md describes them."""
        translations, rotations = self.character.keys(self.clip)
        moved, turned = _changing(translations), _changing(rotations)
        still = [
            {"node": node, path: keys[0].tolist()}
            for path, all_keys in (("translation", translations), ("rotation", rotations))
            for node, keys in all_keys.items()
            if node not in (moved if path == "translation" else turned)
        ]
        frames = self.clip.frame_count
        fields = {"scale": self.scale, "moved": moved, "turned": turned, "still": still, "notes": list(self.notes)}
        return fields, {
            "node_translations": _stacked([translations[node] for node in moved], frames, 3),
            "node_rotations": _stacked([rotations[node] for node in turned], frames, 4),
        }


def _changing(keys: dict[int, Floats]) -> list[int]:
    return [node for node, rows in keys.items() if np.ptp(rows, axis=0).max() > STILL * np.abs(rows).max()]


def _stacked(keys: list[Floats], frames: int, width: int) -> Any:
    """Returns the keys [F, width] of N nodes as one array [F, N, width]."""
    out = np.empty((frames, len(keys), width), np.float32)
    for place, rows in enumerate(keys):
        out[:, place] = rows
    return out
