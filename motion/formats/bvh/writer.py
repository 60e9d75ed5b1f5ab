"""Writes a clip as a BVH file."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats

PIECE = 64  # frames written at once
DIGITS, DECIMALS = 9, 12  # of an offset
ZERO = 5e-7  # a smaller value of a frame is written as 0.000000, not as -0.000000


def dump_bvh(clip: Clip, unit: float = 1.0) -> bytes:
    """Writes a clip as a BVH file: ZXY Euler channels in degrees, joints in depth-first order.

    Args:
        clip: The clip.
        unit: The file's unit of length in metres, such as 0.01 for centimetres.

    Returns:
        The file's bytes. Values of the frames have 6 decimal places, offsets 9 significant digits.

    Example:
        ```python
        from pathlib import Path
        from motionsplice import dump_bvh
        from motionsplice.motion.procedural.library import make

        Path("carry.bvh").write_bytes(dump_bvh(make("walk", "carry_box"), unit=0.01))
        ```
    """
    return b"".join(pieces(clip, unit))


def pieces(clip: Clip, unit: float = 1.0) -> Iterator[bytes]:
    """Yields the bytes of `dump_bvh` in pieces, each of which takes a millisecond or two."""
    from scipy.spatial.transform import Rotation  # takes half a second, and reading does not need it

    order, text = _write_hierarchy(clip, unit)
    header = ["MOTION", f"Frames: {clip.frame_count}", f"Frame Time: {1.0 / clip.rate:.12f}", ""]
    yield "\n".join([*text, *header]).encode()
    line = " ".join(["%.6f"] * (3 + 3 * len(order))) + "\n"
    for first in range(0, clip.frame_count, PIECE):
        frames = slice(first, first + PIECE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # in gimbal lock SciPy sets one angle to 0, which is correct
            turns = Rotation.from_quat(clip.rotations[frames, order].reshape(-1, 4)).as_euler("ZXY", degrees=True)
        places = clip.root_positions[frames] / unit
        values = np.concatenate([places, turns.reshape(len(places), -1)], axis=1)
        values[np.abs(values) < ZERO] = 0.0
        yield "".join([line % tuple(row) for row in values.tolist()]).encode()


def _write_hierarchy(clip: Clip, unit: float) -> tuple[list[int], list[str]]:
    """Returns the joints in the order of the file, and the lines of the hierarchy."""
    skeleton, lines = clip.skeleton, ["HIERARCHY"]
    ends: dict[int, list[int]] = {}
    for end, joint in enumerate(skeleton.end_parents):
        ends.setdefault(int(joint), []).append(end)
    order: list[int] = []
    pending: list[tuple[int, int]] = [(0, 0)]  # with their depth: joints to open, or -1 for a brace to close
    while pending:
        joint, depth = pending.pop()
        tab = "\t" * depth
        if joint < 0:
            lines.append(tab + "}")
            continue
        order.append(joint)
        offset = skeleton.offsets[joint] / unit if joint else np.zeros(3)
        positions = "6 Xposition Yposition Zposition" if joint == 0 else "3"
        lines += [
            f"{tab}{'JOINT' if joint else 'ROOT'} {skeleton.names[joint]}",
            f"{tab}{{",
            _offset(f"{tab}\t", offset),
            f"{tab}\tCHANNELS {positions} Zrotation Xrotation Yrotation",
        ]
        for end in ends.get(joint, []):
            offset = _offset(f"{tab}\t\t", skeleton.end_offsets[end] / unit)
            lines += [f"{tab}\tEnd Site", f"{tab}\t{{", offset, f"{tab}\t}}"]
        pending.append((-1, depth))
        pending += [(child, depth + 1) for child in reversed(skeleton.children[joint])]
    return order, lines


def _offset(tab: str, offset: Floats) -> str:
    """Returns an OFFSET line of plain decimals: many readers know no exponents."""
    values = (np.format_float_positional(round(x, DECIMALS) + 0.0, DIGITS, fractional=False, trim="-") for x in offset)
    return f"{tab}OFFSET {' '.join(values)}"
