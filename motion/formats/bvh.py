"""Reads and writes Biovision Hierarchy (BVH) files.

No reader on PyPI is fast and supports position channels on inner joints (docs/formats.md), hence this one. The
hierarchy is parsed line by line without recursion, the frames by a Numba kernel. Euler channels are intrinsic rotations
in the order of the file; position channels replace the joint's offset.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from decimal import Decimal

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError
from motionsplice.motion.formats.decimals import is_finite, read_table
from motionsplice.motion.formats.fold import Nodes, still
from motionsplice.motion.quaternion import Floats

CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")
SHORTEST_STEP, LONGEST_STEP = 1e-4, 2.0  # seconds per frame
BLOCK = 256  # frames converted to rotations at once, so that their angles stay in a core's cache
PIECE = 64  # frames written at once
CUT_SHORT = "Export the file again; it may be cut short"


@dataclass
class _Joint:
    name: str
    parent: int
    line: int
    offset: list[float] = field(default_factory=list)
    channels: list[str] | None = None
    is_end: bool = False


def parse(data: bytes) -> tuple[Nodes, float]:
    """Parses a BVH file: its joints and motion, in the file's unit, and its frames per second. Raises FormatError."""
    if b"\0" in data:
        raise FormatError("this is a binary file, not BVH text", mend="Export the motion as BVH")
    lines = data.decode("utf-8-sig", errors="replace").splitlines()
    joints, line = _hierarchy(lines)
    count, rate, line = _motion_header(lines, line)
    width = sum(len(joint.channels or ()) for joint in joints)
    return _nodes(joints, _frames(lines, line, count, width), len(data)), rate


def _hierarchy(lines: list[str]) -> tuple[list[_Joint], int]:
    """Returns all joints and end sites, and the index of the line with MOTION."""
    joints: list[_Joint] = []
    open_joints: list[int] = []  # joints whose brace is open
    started = waiting = False  # waiting: the next word must be an opening brace
    for number, (word, *rest) in _statements(lines):
        match word.upper():
            case "HIERARCHY" if not started:
                started = True
            case _ if not started:
                problem = f"expected HIERARCHY, the first word of a BVH file, found {word[:40]!r}"
                raise FormatError(problem, place=f"line {number + 1}", mend="Export the motion as BVH")
            case "ROOT" | "JOINT" | "END" if not waiting:
                is_end = word.upper() == "END"
                if not rest or (not is_end and (word.upper() == "ROOT") != (not joints)) or (is_end and not joints):
                    raise FormatError("expected one ROOT with named JOINTs below it", place=f"line {number + 1}")
                if joints and not open_joints:
                    raise FormatError("a joint is outside the ROOT's braces", place=f"line {number + 1}")
                parent = open_joints[-1] if open_joints else -1
                if joints and joints[parent].is_end:
                    raise FormatError("an End Site cannot have children", place=f"line {number + 1}")
                joints.append(_Joint(" ".join(rest), parent, number + 1, is_end=is_end))
                waiting = True
            case "{" if waiting:
                open_joints.append(len(joints) - 1)
                waiting = False
            case "}" if open_joints and not waiting:
                _check_closed(joints[open_joints.pop()], number + 1)
            case "OFFSET" if open_joints and not waiting:
                joints[open_joints[-1]].offset = _offset(rest, number + 1)
            case "CHANNELS" if open_joints and not waiting:
                _give_channels(joints[open_joints[-1]], _channels(rest, number + 1), number + 1)
            case "MOTION" if joints and not open_joints and not waiting:
                return joints, number
            case _:
                raise FormatError(f"unexpected {' '.join([word, *rest])[:40]!r}", place=f"line {number + 1}")
    raise FormatError("the file ends inside the hierarchy, before MOTION", place=f"line {len(lines)}", mend=CUT_SHORT)


def _statements(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Yields each statement as its line index and words. A brace may follow on the line of the name that it opens."""
    for number, text in enumerate(lines):
        words = text.split()
        if len(words) > 1 and words[-1] == "{":
            yield number, words[:-1]
            words = ["{"]
        if words:
            yield number, words


def _give_channels(joint: _Joint, channels: list[str], line: int) -> None:
    if joint.channels is not None:
        raise FormatError(f"joint {joint.name!r} has a second CHANNELS line", place=f"line {line}")
    if joint.is_end and channels:
        raise FormatError("an End Site cannot have CHANNELS", place=f"line {line}", mend="Make it a JOINT")
    joint.channels = channels


def _check_closed(joint: _Joint, line: int) -> None:
    if not joint.offset:
        raise FormatError(f"joint {joint.name!r} has no OFFSET", place=f"line {line}")


def _offset(words: list[str], line: int) -> list[float]:
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) != 3 or not all(map(math.isfinite, values)):
        raise FormatError("OFFSET needs three finite numbers", place=f"line {line}")
    return values


def _channels(words: list[str], line: int) -> list[str]:
    channels = [word.capitalize() for word in words[1:]]
    if not words or words[0] != str(len(channels)):
        declared = words[0][:20] if words else "nothing"
        raise FormatError(f"CHANNELS declares {declared}, but names {len(channels)} channels", place=f"line {line}")
    if unknown := [word for word in channels if word not in CHANNELS]:
        raise FormatError(f"unknown channel {unknown[0]!r}", place=f"line {line}", mend=f"Use {', '.join(CHANNELS)}")
    if len(set(channels)) != len(channels):
        raise FormatError("CHANNELS lists a channel twice", place=f"line {line}")
    return channels


def _motion_header(lines: list[str], line: int) -> tuple[int, float, int]:
    """Returns the frame count, the frames per second and the index of the first line of frames."""
    found: dict[str, str] = {}
    for number in range(line + 1, len(lines)):
        key, _, value = lines[number].partition(":")
        if not lines[number].strip():
            continue
        name = "".join(key.split()).lower()
        try:
            if name not in ("frames", "frametime"):
                raise ValueError
            found[name] = value.strip()
            float(value)
        except ValueError:
            problem = f"expected 'Frames: N' and 'Frame Time: seconds', found {lines[number].strip()[:40]!r}"
            raise FormatError(problem, place=f"line {number + 1}") from None
        if len(found) == 2:
            count, step = float(found["frames"]), float(found["frametime"])
            whole = count >= 0 and math.isfinite(count) and count == int(count)
            if not (whole and SHORTEST_STEP <= step <= LONGEST_STEP):
                problem = f"the header is invalid: {count:g} frames of {step:g} s each"
                mend = f"Give a whole number of frames and {SHORTEST_STEP:g} to {LONGEST_STEP:g} seconds per frame"
                raise FormatError(problem, place=f"line {number + 1}", mend=mend)
            return int(count), _rate(found["frametime"]), number + 1
    raise FormatError("the file ends before the frames", place=f"line {len(lines)}", mend=CUT_SHORT)


def _rate(text: str) -> float:
    """Returns frames per second: a whole rate if its step, rounded or truncated, gives the digits of `text`."""
    step, last_digit = float(text), 10.0 ** float(Decimal(text).as_tuple().exponent)
    whole = float(round(1.0 / step))
    return whole if whole > 0.0 and abs(1.0 / whole - step) < last_digit else 1.0 / step


def _frames(lines: list[str], first: int, count: int, width: int) -> Floats:
    """Returns all channel values [F, width]. Allocates for the rows that exist, whatever the header claims."""
    rows = [(number, text) for number, text in enumerate(lines[first:], first + 1) if text.strip()]
    if len(rows) != count:
        problem = f"expected {count} frames, as the header says, found {len(rows)}"
        raise FormatError(problem, place="after 'Frame Time'", mend=CUT_SHORT)
    if count == 0:
        raise FormatError("the file has no frames", mend="Export the motion, not only the rig")
    values = read_table("\n".join(text for _, text in rows), count, width)
    if values is not None:
        return values
    raise _first_bad_row(rows, width)


def _first_bad_row(rows: list[tuple[int, str]], width: int) -> FormatError:
    for frame, (number, text) in enumerate(rows):
        words = text.split()
        place = f"line {number}, frame {frame}"
        if len(words) != width:
            return FormatError(f"expected {width} values per frame, found {len(words)}", place=place, mend=CUT_SHORT)
        if invalid := [word for word in words if not is_finite(word)]:
            return FormatError(f"{invalid[0][:20]!r} is not a finite number", place=place)
    return FormatError(f"expected {width} plain decimal numbers in every frame")


def _nodes(joints: list[_Joint], values: Floats, size: int) -> Nodes:
    """Returns the joints and their motion, with end sites apart; `values` [F, width], `size` bytes of the file."""
    places = {number: place for place, number in enumerate(n for n, joint in enumerate(joints) if not joint.is_end)}
    real, ends = [joint for joint in joints if not joint.is_end], [joint for joint in joints if joint.is_end]
    rotations = still(len(values), len(real), size)
    translations: dict[int, Floats] = {}
    by_order: dict[str, list[tuple[int, list[int]]]] = {}  # joints and their columns, by Euler order: converted at once
    column = 0
    for place, joint in enumerate(real):
        channels = joint.channels or []
        turns = [number for number, channel in enumerate(channels) if channel.endswith("rotation")]
        order = "".join(channels[number][0] for number in turns).lower()
        by_order.setdefault(order, []).append((place, [column + number for number in turns]))
        if len(turns) < len(channels):
            translations[place] = np.tile(np.array(joint.offset), (len(values), 1))
            for number, channel in enumerate(channels):
                if channel.endswith("position"):
                    translations[place][:, "XYZ".index(channel[0])] = values[:, column + number]
        column += len(channels)
    for order, turning in by_order.items():
        at, columns = [place for place, _ in turning], [own for _, own in turning]
        for first in range(0, len(values) if order else 0, BLOCK):
            halves = np.radians(values[first : first + BLOCK, columns]) * 0.5
            rotations[first : first + BLOCK, at] = quaternion.from_euler(order, np.sin(halves), np.cos(halves))
    return Nodes(
        names=tuple(joint.name for joint in real),
        parents=np.array([places.get(joint.parent, -1) for joint in real]),
        offsets=np.array([joint.offset for joint in real]),
        end_parents=np.array([places[joint.parent] for joint in ends], np.int64),
        end_offsets=np.array([joint.offset for joint in ends]).reshape(-1, 3),
        translations=translations,
        rotations=rotations,
    )


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
    header = ["MOTION", f"Frames: {clip.frame_count}", f"Frame Time: {1.0 / clip.rate:.9g}", ""]
    yield "\n".join([*text, *header]).encode()
    line = " ".join(["%.6f"] * (3 + 3 * len(order))) + "\n"
    for first in range(0, clip.frame_count, PIECE):
        frames = slice(first, first + PIECE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # in gimbal lock SciPy sets one angle to 0, which is correct
            turns = Rotation.from_quat(clip.rotations[frames, order].reshape(-1, 4)).as_euler("ZXY", degrees=True)
        places = clip.root_positions[frames] / unit
        values = np.concatenate([places, turns.reshape(len(places), -1)], axis=1)
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
        x, y, z = skeleton.offsets[joint] / unit if joint else (0.0, 0.0, 0.0)
        positions = "6 Xposition Yposition Zposition" if joint == 0 else "3"
        lines += [
            f"{tab}{'JOINT' if joint else 'ROOT'} {skeleton.names[joint]}",
            f"{tab}{{",
            f"{tab}\tOFFSET {x:.9g} {y:.9g} {z:.9g}",
            f"{tab}\tCHANNELS {positions} Zrotation Xrotation Yrotation",
        ]
        for end in ends.get(joint, []):
            x, y, z = skeleton.end_offsets[end] / unit
            lines += [f"{tab}\tEnd Site", f"{tab}\t{{", f"{tab}\t\tOFFSET {x:.9g} {y:.9g} {z:.9g}", f"{tab}\t}}"]
        pending.append((-1, depth))
        pending += [(child, depth + 1) for child in reversed(skeleton.children[joint])]
    return order, lines
