"""The Virtual Motion Capture protocol (VMC, https://protocol.vmc.info): a person's bones as OSC messages."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.axes import AXES
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.gltf.humanoid_pose import Humanoid
from motionsplice.motion.formats.gltf.t_pose import t_pose
from motionsplice.motion.roles import Roles
from motionsplice.sending.osc import bundled, message

MOST = 1452  # bytes of a datagram that Ethernet carries whole: 1,500 without the headers of IPv6 and UDP
UNITY = np.array([*AXES["unity"].signs, *AXES["unity"].turns, 1.0])  # signs of a position and a rotation there
THUMB = {"Metacarpal": "Proximal", "Proximal": "Intermediate", "Distal": "Distal"}  # VRM 1.0's names, and Unity's
STILL = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


class Vmc:
    """Packs poses of one rig into bundles that each fit into a datagram.

    The hips carry the path; `/VMC/Ext/Root/Pos` stays at the origin, because not all receivers use it.

    Args:
        clip: A motion of the rig, best a walk: some rigs show their T-pose only in motion.
        roles: The roles of its joints.

    Attributes:
        bones: Names of Unity's HumanBodyBones, in the order in which they are sent.
    """

    def __init__(self, clip: Clip, roles: Roles) -> None:
        self._person = Humanoid(clip.skeleton, roles, t_pose(clip, roles))
        self.bones = [_unity_name(bone) for bone in self._person.bones]
        messages = [message("/VMC/Ext/Root/Pos", "root", *STILL)]
        messages += [message("/VMC/Ext/Bone/Pos", bone, *STILL) for bone in self.bones]
        messages += [message("/VMC/Ext/OK", 1), message("/VMC/Ext/T", 0.0)]
        bundles, ends = bundled(messages, MOST)
        buffer = bytearray().join(bundles)
        limits = np.cumsum([0, *map(len, bundles)]).tolist()
        self._datagrams = [memoryview(buffer)[start:end] for start, end in pairwise(limits)]
        self._words = np.frombuffer(buffer, ">f4")  # each message ends with its numbers
        self._of_bones = np.array(ends[1:-2])[:, None] // 4 + np.arange(-7, 0)
        self._of_time = ends[-1] // 4 - 1

    def datagrams(self, seconds: float, root_position: NDArray[Any], rotations: NDArray[Any]) -> list[memoryview]:
        """Returns the datagrams of a frame; the next call overwrites them.

        Args:
            seconds: Time since the first frame.
            root_position: [3] metres.
            rotations: [J, 4] each in its parent's frame.
        """
        positions, turns = self._person.local(root_position, rotations)
        self._words[self._of_bones] = np.concatenate([positions, turns], axis=1) * UNITY
        self._words[self._of_time] = seconds
        return self._datagrams


def _unity_name(bone: str) -> str:
    """Returns Unity's name of a bone of VRM 1.0."""
    side, thumb, part = bone.partition("Thumb")
    name = side + thumb + THUMB[part] if thumb else bone
    return name[0].upper() + name[1:]
