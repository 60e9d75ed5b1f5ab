"""Biovision Hierarchy (BVH), read and written.

No reader on PyPI takes position channels on inner joints and is fast (docs/formats.md), so this is ours: the hierarchy
is parsed line by line without recursion, the frames by NumPy. Euler channels are intrinsic rotations in the order in
which they stand; position channels replace the joint's offset.
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
from motionsplice.motion.formats.decimals import read_table
from motionsplice.motion.formats.fold import Nodes, still
from motionsplice.motion.quaternion import Floats

CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")
SHORTEST_STEP, LONGEST_STEP = 1e-4, 2.0  # seconds per frame
BLOCK = 256  # frames whose angles stay in a core's cache while they become rotations
PIECE = 64  # frames that are written at once
CUT_SHORT = "The file may be cut short: export it again"


@dataclass
class _Joint:
    name: str
    parent: int
    line: int
    offset: list[float] = field(default_factory=list)
    channels: list[str] | None = None
    is_end: bool = False


def parse(data: bytes) -> tuple[Nodes, float]:
    """The joints and motion in a BVH file, in its own unit, and its frames per second. Raises FormatError."""
    if b"\0" in data:
        raise FormatError("this is a binary file, not BVH text", mend="Export it as BVH")
    lines = data.decode("utf-8-sig", errors="replace").splitlines()
    joints, line = _hierarchy(lines)
    count, rate, line = _motion_header(lines, line)
    width = sum(len(joint.channels or ()) for joint in joints)
    return _nodes(joints, _frames(lines, line, count, width), len(data)), rate


def _hierarchy(lines: list[str]) -> tuple[list[_Joint], int]:
    """All joints and end sites, and the number of the line with MOTION."""
    joints: list[_Joint] = []
    open_joints: list[int] = []  # those whose brace is open
    started = waiting = False  # waiting for a brace
    for number, (word, *rest) in _statements(lines):
        match word.upper():
            case "HIERARCHY" if not started:
                started = True
            case _ if not started:
                raise FormatError("a BVH file begins with HIERARCHY", place=f"line {number + 1}", mend="Is it one?")
            case "ROOT" | "JOINT" | "END" if not waiting:
                is_end = word.upper() == "END"
                if not rest or (not is_end and (word.upper() == "ROOT") != (not joints)) or (is_end and not joints):
                    raise FormatError("one ROOT with JOINTs below it was expected", place=f"line {number + 1}")
                if joints and not open_joints:
                    raise FormatError("a joint lies outside the root", place=f"line {number + 1}")
                parent = open_joints[-1] if open_joints else -1
                if joints and joints[parent].is_end:
                    raise FormatError("nothing can hang on an End Site", place=f"line {number + 1}")
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
                raise FormatError(f"{' '.join([word, *rest])[:40]!r} was not expected here", place=f"line {number + 1}")
    raise FormatError("it ends inside the hierarchy, before MOTION", place=f"line {len(lines)}", mend=CUT_SHORT)


def _statements(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Numbered statements as words. A brace may stand behind the name it opens."""
    for number, text in enumerate(lines):
        words = text.split()
        if len(words) > 1 and words[-1] == "{":
            yield number, words[:-1]
            words = ["{"]
        if words:
            yield number, words


def _give_channels(joint: _Joint, channels: list[str], line: int) -> None:
    if joint.channels is not None:
        raise FormatError(f"joint {joint.name!r} has CHANNELS twice", place=f"line {line}")
    if joint.is_end and channels:
        raise FormatError("an End Site has CHANNELS", place=f"line {line}", mend="Make it a JOINT")
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
        raise FormatError(f"CHANNELS names {len(channels)} channels, not the number it says", place=f"line {line}")
    if unknown := [word for word in channels if word not in CHANNELS]:
        raise FormatError(f"unknown channel {unknown[0]!r}", place=f"line {line}", mend=f"Use {', '.join(CHANNELS)}")
    if len(set(channels)) != len(channels):
        raise FormatError("CHANNELS names a channel twice", place=f"line {line}")
    return channels


def _motion_header(lines: list[str], line: int) -> tuple[int, float, int]:
    """The frame count, frames per second and the number of the first line of frames."""
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
            expected = "'Frames: N' and 'Frame Time: seconds'"
            raise FormatError(f"{expected} were expected", place=f"line {number + 1}") from None
        if len(found) == 2:
            count, step = float(found["frames"]), float(found["frametime"])
            if not (
                count >= 0 and math.isfinite(count) and count == int(count) and SHORTEST_STEP <= step <= LONGEST_STEP
            ):
                problem = f"{count:g} frames of {step:g} s are not a motion"
                raise FormatError(problem, place=f"line {number + 1}", mend="Frame Time is seconds per frame")
            return int(count), _rate(found["frametime"]), number + 1
    raise FormatError("it ends before the frames", place=f"line {len(lines)}", mend=CUT_SHORT)


def _rate(text: str) -> float:
    """Frames per second; a step that is a whole rate's to its last digit, rounded or cut, means that rate."""
    step, last_digit = float(text), 10.0 ** float(Decimal(text).as_tuple().exponent)
    whole = float(round(1.0 / step))
    return whole if whole > 0.0 and abs(1.0 / whole - step) < last_digit else 1.0 / step


def _frames(lines: list[str], first: int, count: int, width: int) -> Floats:
    """All channel values [F, width]. Allocates for what is there, whatever the header says."""
    rows = [(number, text) for number, text in enumerate(lines[first:], first + 1) if text.strip()]
    if len(rows) != count:
        problem = f"the header says {count} frames, and {len(rows)} are there"
        raise FormatError(problem, place="after 'Frame Time'", mend=CUT_SHORT)
    if count == 0:
        raise FormatError("it has no frames", mend="Export the motion, not the rig alone")
    values = read_table("\n".join(text for _, text in rows), count, width)
    if values is not None:
        return values
    raise _first_bad_row(rows, width)


def _first_bad_row(rows: list[tuple[int, str]], width: int) -> FormatError:
    for frame, (number, text) in enumerate(rows):
        words = text.split()
        place = f"line {number}, frame {frame}"
        if len(words) != width:
            return FormatError(f"{len(words)} values where the channels need {width}", place=place, mend=CUT_SHORT)
        for word in words:
            try:
                sound = math.isfinite(float(word))
            except ValueError:
                sound = False
            if not sound:
                return FormatError(f"{word[:20]!r} is not a finite number", place=place)
    return FormatError(f"the frames do not have {width} values each")


def _nodes(joints: list[_Joint], values: Floats, size: int) -> Nodes:
    """Joints without end sites, and their motion."""
    places = {number: place for place, number in enumerate(n for n, joint in enumerate(joints) if not joint.is_end)}
    real, ends = [joint for joint in joints if not joint.is_end], [joint for joint in joints if joint.is_end]
    rotations = still(len(values), len(real), size)
    translations: dict[int, Floats] = {}
    alike: dict[str, list[tuple[int, list[int]]]] = {}  # joints and their columns by order of axes, to do at once
    column = 0
    for place, joint in enumerate(real):
        channels = joint.channels or []
        turns = [number for number, channel in enumerate(channels) if channel.endswith("rotation")]
        order = "".join(channels[number][0] for number in turns).lower()
        alike.setdefault(order, []).append((place, [column + number for number in turns]))
        if len(turns) < len(channels):
            translations[place] = np.tile(np.array(joint.offset), (len(values), 1))
            for number, channel in enumerate(channels):
                if channel.endswith("position"):
                    translations[place][:, "XYZ".index(channel[0])] = values[:, column + number]
        column += len(channels)
    for order, turning in alike.items():
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
    """A clip as BVH: ZXY Euler channels in degrees, lengths in `unit` metres, joints in depth-first order."""
    return b"".join(pieces(clip, unit))


def pieces(clip: Clip, unit: float = 1.0) -> Iterator[bytes]:
    """What `dump_bvh` gives, in pieces that each take a millisecond or two to make."""
    from scipy.spatial.transform import Rotation  # half a second, which those who only read need not wait

    order, text = _write_hierarchy(clip, unit)
    header = ["MOTION", f"Frames: {clip.frame_count}", f"Frame Time: {1.0 / clip.rate:.9g}", ""]
    yield "\n".join([*text, *header]).encode()
    line = " ".join(["%.6f"] * (3 + 3 * len(order))) + "\n"
    for first in range(0, clip.frame_count, PIECE):
        frames = slice(first, first + PIECE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # in gimbal lock SciPy sets one angle to 0, which is right
            turns = Rotation.from_quat(clip.rotations[frames, order].reshape(-1, 4)).as_euler("ZXY", degrees=True)
        places = clip.root_positions[frames] / unit
        values = np.concatenate([places, turns.reshape(len(places), -1)], axis=1)
        yield "".join([line % tuple(row) for row in values.tolist()]).encode()


def _write_hierarchy(clip: Clip, unit: float) -> tuple[list[int], list[str]]:
    """Joints in the order in which they are written, and the lines of the hierarchy."""
    skeleton, lines = clip.skeleton, ["HIERARCHY"]
    ends: dict[int, list[int]] = {}
    for end, joint in enumerate(skeleton.end_parents):
        ends.setdefault(int(joint), []).append(end)
    order: list[int] = []
    pending: list[tuple[int, int]] = [(0, 0)]  # joints to open, or, as -1, a brace to close, with their depth
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
