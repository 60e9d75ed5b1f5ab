"""What clients say that they show, next to what the protocol describes."""

from __future__ import annotations

import base64
from typing import Any

import msgpack
import numpy as np
from scipy.spatial.transform import Rotation

from tests.service.messages import arrays


def placed(sample: dict[str, Any], encoding: str) -> Any:
    """Returns the joints of a message, placed in 64 bits as the protocol describes, in the client's order."""
    message = msgpack.unpackb(base64.b64decode(sample["message"]))
    parents, offsets = sample["parents"], np.reshape(sample["offsets"], (-1, 3))
    ids = np.frombuffer(message["ids"], "<u4")
    found = arrays(message, len(parents), message["count"] * len(ids), short=encoding == "int16")
    places = [found["root_positions"].astype(float)]
    turns = [Rotation.from_quat(found["rotations"][:, 0])]
    for joint, parent in enumerate(parents[1:], 1):
        places.append(places[parent] + turns[parent].apply(offsets[joint]))
        turns.append(turns[parent] * Rotation.from_quat(found["rotations"][:, joint]))
    return np.stack(places, axis=1).ravel()
