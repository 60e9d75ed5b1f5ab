"""JSON Live Link: a skeleton as JSON, for the plugin JSONLiveLink of Unreal's Live Link."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

from motionsplice.motion.axes import AXES
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.skeleton import Skeleton

MOST = 65_507  # bytes that a datagram can have
SUBJECT = "motionsplice"
UNREAL = AXES["unreal"]
ORDER, SIGNS = [*UNREAL.order, 3], np.array([*UNREAL.turns, 1.0])  # of a rotation there


class LiveLink:
    """Packs poses of one rig: all joints, each in its parent's frame, in Unreal's axes and centimetres.

    A frame is one datagram, however large, because the plugin takes each datagram for a whole skeleton.

    Args:
        skeleton: The rig.
        subject: The name under which Live Link lists it.
    """

    def __init__(self, skeleton: Skeleton, subject: str = SUBJECT) -> None:
        self._subject = subject
        self._locations = UNREAL.positions(skeleton.offsets).astype(np.float32, order="C")
        self._bones = [
            # in ASCII, because the plugin reads each byte as a character
            {"Name": orjson.Fragment(json.dumps(name)), "Parent": parent, "Location": location, "Scale": [1, 1, 1]}
            for name, parent, location in zip(skeleton.names, skeleton.parents.tolist(), self._locations, strict=True)
        ]

    def datagrams(self, seconds: float, root_position: NDArray[Any], rotations: NDArray[Any]) -> list[bytes]:
        """Returns the one datagram of a frame.

        Args:
            seconds: Time since the first frame; not sent.
            root_position: [3] metres.
            rotations: [J, 4] each in its parent's frame.

        Raises:
            SkeletonError: The rig has too many joints for a datagram.
        """
        self._locations[0] = UNREAL.positions(root_position.astype(np.float64))
        turned = (rotations[:, ORDER] * SIGNS).astype(np.float32, order="C")
        for bone, rotation in zip(self._bones, turned, strict=True):
            bone["Rotation"] = rotation
        datagram = orjson.dumps({self._subject: self._bones}, option=orjson.OPT_SERIALIZE_NUMPY)
        if len(datagram) > MOST:
            problem = f"{len(self._bones)} joints take {len(datagram)} bytes, but a datagram has at most {MOST}"
            raise SkeletonError(problem, mend="Use --vmc, or a rig with fewer joints")
        return [datagram]
