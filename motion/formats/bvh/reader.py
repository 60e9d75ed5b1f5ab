"""Reads Biovision Hierarchy (BVH) files.

No reader on PyPI is fast and supports position channels on inner joints (docs/formats.md), hence this one. Euler
channels are intrinsic rotations in the order of the file; position channels replace the joint's offset.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from motionsplice.motion.errors import FormatError, did_you_mean, listed
from motionsplice.motion.formats.bvh.frames import Frames, Header, read_frames, read_header
from motionsplice.motion.formats.bvh.hierarchy import Hierarchy, Joint, check_doubles, number_doubles, read_hierarchy
from motionsplice.motion.formats.bvh.turns import fill_rotations
from motionsplice.motion.formats.decimals import read_table
from motionsplice.motion.formats.fold import Nodes, still
from motionsplice.motion.formats.parsed import Parsed
from motionsplice.motion.formats.text import text_of
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.rates import CLOSE, meant_rate
from motionsplice.motion.role_names import roles_by_name
from motionsplice.motion.roles import ENDS

# In nearly all files, the last line of the hierarchy, and then that of the header.
MOTION = re.compile(rb"^[ \t]*motion[^\n]*\n", re.IGNORECASE | re.MULTILINE)
FRAME_TIME = re.compile(rb"^[ \t]*frame[ _]?time[^\n]*\n", re.IGNORECASE | re.MULTILINE)
LARGEST_REMEMBERED = 100_000  # bytes of a hierarchy


class Contents(NamedTuple):
    """The parts of a file."""

    hierarchy: Hierarchy
    header: Header
    frames: Frames


def parse(data: bytes, root: str | None = None) -> Parsed:
    """Parses a BVH file: its joints and motion, in the file's unit, and its frames per second.

    Args:
        data: The file's bytes.
        root: A joint of the skeleton to read, of a file with several ROOTs. None takes the first with legs and arms,
            or else the first.

    Raises:
        FormatError: The file is malformed; the message names the line.
    """
    hierarchy, header, frames = _plain_contents(data) or _contents(data)
    joints = list(hierarchy.joints)
    rate = meant_rate(header.step)
    notes = [*hierarchy.notes, *frames.notes]
    if abs(rate * float(header.step) - 1.0) > CLOSE:
        notes.append(f"a frame time of {header.step} s was read as {rate:.5g} frames per second")
    first, others = _choose(joints, root)
    if others:
        notes.append(f"read the skeleton {joints[first].name!r}; choose another with --root: {listed(others)}")
    check_doubles(joints, first)
    body = [place for place in range(first, joints[first].end) if not joints[place].is_end]
    if renamed := number_doubles(joints, body):
        notes.append(f"renamed, because another joint has the same name: {listed(renamed)}")
    nodes = _nodes(joints, first, frames.values, len(data))
    return Parsed(nodes, rate, notes=tuple(dict.fromkeys(notes)), warnings=frames.warnings)


def _plain_contents(data: bytes) -> Contents | None:
    """Returns what a file says whose frames are nothing but numbers, one line each, as many as it declares.

    Such frames are read from the bytes; only what precedes them is text. Returns None for other files.
    """
    motion, last = MOTION.search(data), FRAME_TIME.search(data)
    if motion is None or last is None:
        return None
    try:
        text, lines = data[: motion.end()], _lines(data[motion.end() : last.end()])
        hierarchy = _remembered(text) if len(text) <= LARGEST_REMEMBERED else _hierarchy(text)
        header = read_header(lines, -1)
    except FormatError:
        return None
    rows = np.frombuffer(data, np.uint8, offset=last.end())
    whole = header.count > 0 and header.end == len(lines)
    values = read_table(rows, header.count, _width(hierarchy.joints)) if whole else None
    header = replace(header, end=hierarchy.line + 1 + header.end)
    return None if values is None else Contents(hierarchy, header, Frames(values))


def _hierarchy(text: bytes) -> Hierarchy:
    """Returns the hierarchy that ends with the last line. Raises FormatError."""
    lines = _lines(text)
    hierarchy = read_hierarchy(lines)
    if hierarchy.line < len(lines) - 1:
        raise FormatError("the hierarchy ends before its last line")
    return hierarchy


_remembered = lru_cache(maxsize=16)(_hierarchy)  # the clips of a bank are of few rigs


def _contents(data: bytes) -> Contents:
    """Returns what a file says. Raises FormatError."""
    lines = _lines(data)
    hierarchy = read_hierarchy(lines)
    header = read_header(lines, hierarchy.line)
    cut = not data.endswith((b"\n", b"\r"))
    return Contents(hierarchy, header, read_frames(lines, header, _width(hierarchy.joints), cut))


def _lines(data: bytes) -> list[str]:
    return text_of(data, mend="Export the motion as BVH").splitlines()


def _real(joints: list[Joint]) -> list[Joint]:
    return [joint for joint in joints if not joint.is_end]


def _width(joints: Sequence[Joint]) -> int:
    """Returns the number of values in a frame."""
    return sum(len(joint.channels or ()) for joint in joints)


def _choose(joints: list[Joint], root: str | None) -> tuple[int, list[str]]:
    """Returns the index of the ROOT to read, and the names of others if none was asked for.

    ROOTs of the same name are numbered. Raises FormatError for an unknown joint.
    """
    roots = [place for place, joint in enumerate(joints) if joint.parent < 0]
    number_doubles(joints, roots)
    names = [joints[place].name for place in roots]
    if root is not None:
        found = [place for place, joint in enumerate(joints) if joint.name == root and not joint.is_end]
        if not found:
            raise FormatError(f"unknown joint {root!r} for --root", mend=did_you_mean(root, names))
        return max(place for place in roots if place <= found[0]), []
    limbs = (place for place in roots if _has_limbs(joints[place : joints[place].end]))
    chosen = roots[0] if len(roots) == 1 else next(limbs, roots[0])
    return chosen, [name for name in names if name != joints[chosen].name]


def _has_limbs(joints: list[Joint]) -> bool:
    return set(ENDS) <= set(roles_by_name(tuple(joint.name for joint in _real(joints))))


def _nodes(joints: list[Joint], root: int, values: Floats, size: int) -> Nodes:
    """Returns the joints below `root` and their motion, with end sites apart.

    `values` [F, width] are those of all joints; the file has `size` bytes.
    """
    column = _width(joints[:root])
    joints = joints[root : joints[root].end]
    places = {number: place for place, number in enumerate(n for n, joint in enumerate(joints) if not joint.is_end)}
    real, ends = _real(joints), [joint for joint in joints if joint.is_end]
    rotations = still(len(values), len(real), size)
    translations: dict[int, Floats] = {}
    by_order: dict[str, list[tuple[int, list[int]]]] = {}  # joints and their columns, by Euler order: converted at once
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
        if order:
            at, columns = np.array([place for place, _ in turning]), np.array([own for _, own in turning])
            fill_rotations(rotations, at, order, values, columns)
    return Nodes(
        names=tuple(joint.name for joint in real),
        parents=np.array([places.get(joint.parent - root, -1) for joint in real]),
        offsets=np.array([joint.offset for joint in real]),
        end_parents=np.array([places[joint.parent - root] for joint in ends], np.int64),
        end_offsets=np.array([joint.offset for joint in ends]).reshape(-1, 3),
        translations=translations,
        rotations=rotations,
    )
