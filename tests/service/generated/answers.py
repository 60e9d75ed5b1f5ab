"""Checks what a generated client has written: the answers to the same request in all their forms."""

from __future__ import annotations

import json
from pathlib import Path

import msgpack
import numpy as np

from motionsplice.motion.formats.reading import read_clip
from motionsplice.runtime.bank import Bank
from tests.service.messages import arrays, unpacked


def check_answers(folder: Path, bank: Bank) -> None:
    """Checks that the files are the bank's, and that poses are the same in JSON, MessagePack and a stream."""
    joints = bank.skeleton.joint_count
    assert (folder / "manifest.msgpack").read_bytes() == (bank.path / "manifest.msgpack").read_bytes()
    assert (folder / "lower.npy").read_bytes() == bank.files["lower"].read_bytes()
    for name, leading in (("pose", ()), ("poses", (2,)), ("splice", (4,))):
        packed = arrays(msgpack.unpackb((folder / f"{name}.msgpack").read_bytes()), joints, *leading)
        as_json = json.loads((folder / f"{name}.json").read_bytes())
        assert set(packed) == {"root_positions", "rotations", "world_positions"}
        for key, array in packed.items():
            np.testing.assert_array_equal(np.array(as_json[key], np.float32), array)
    header, *messages = unpacked((folder / "frames.stream").read_bytes())
    assert (header["frames"], len(messages)) == (4, 2)
    streamed = np.concatenate([arrays(one, joints, 2)["world_positions"] for one in messages])
    np.testing.assert_array_equal(streamed, np.array(as_json["world_positions"], np.float32))
    for form in ("bvh", "glb", "gltf", "vrma"):
        assert read_clip(folder / f"splice.{form}").clip.frame_count == 4
