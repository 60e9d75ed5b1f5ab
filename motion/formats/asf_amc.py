"""Acclaim skeletons (ASF) and motions (AMC), as of the CMU database.

A bone's joint sits where the bone begins, as in the BVH conversions of the database. A bone rotates about axes of its
own, C; since C R C^-1 is the rotation in the parent's frame, local frames are aligned with the world in the bind pose.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError, did_you_mean
from motionsplice.motion.formats.decimals import read_table
from motionsplice.motion.formats.fold import Nodes, still
from motionsplice.motion.quaternion import Floats

INCH = 0.0254  # metres; an ASF's unit of length is so many inches
RATE = 120.0  # frames per second, unless the file says otherwise
CUT_SHORT = "The file may be cut short: fetch it again"


@dataclass
class Bone:
    """One bone: from its joint to its tip in the bind pose [3], in the file's unit, its axes C [4], and its dof."""

    tip: Floats
    axes: Floats
    dof: tuple[str, ...]
    children: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class AcclaimSkeleton:
    """What an ASF file says. `order` is that of the root's channels; unit is in metres."""

    bones: dict[str, Bone]
    order: tuple[str, ...]
    unit: float

    def nodes(self) -> list[tuple[str, int]]:
        """All joints, parent before child and depth first, each with the place of its parent."""
        ordered: list[tuple[str, int]] = []
        pending = [("root", -1)]
        while pending:
            name, parent = pending.pop()
            ordered.append((name, parent))
            pending += [(child, len(ordered) - 1) for child in reversed(self.bones[name].children)]
        return ordered


def parse_skeleton(data: bytes) -> AcclaimSkeleton:
    """Reads an ASF file. Raises FormatError, saying the line."""
    sections: dict[str, list[tuple[int, list[str]]]] = {}
    section: list[tuple[int, list[str]]] | None = None
    for number, words in _lines(data):
        if words[0].startswith(":"):
            section = sections.setdefault(words[0][1:].lower(), [])
            section += [(number, words[1:])] if words[1:] else []
        elif section is not None:
            section.append((number, words))
    for name in ("units", "root", "bonedata", "hierarchy"):
        if name not in sections:
            raise FormatError(f"it has no :{name} section", mend=CUT_SHORT)
    units = {words[0].lower(): words[1:] for _, words in sections["units"]}
    root = {words[0].lower(): (number, words[1:]) for number, words in sections["root"]}
    degrees = not (units.get("angle") or ["deg"])[0].lower().startswith("rad")
    number, order = root.get("order", (0, []))
    channels = tuple(word.lower() for word in order)
    if sorted(channels) != ["rx", "ry", "rz", "tx", "ty", "tz"]:
        raise FormatError("the root's order must be TX TY TZ RX RY RZ in some order", place=f"line {number}")
    axis = root.get("axis", (0, ["XYZ"]))[1]
    number, orientation = root.get("orientation", (0, ["0", "0", "0"]))
    bones = {"root": Bone(np.zeros(3), _axes([*orientation, *axis], degrees, number), channels)}
    for bone in _bone_blocks(sections["bonedata"]):
        name, made = _bone(bone, degrees)
        if name in bones:
            raise FormatError(f"bone {name!r} stands twice", place=f"line {bone['name'][0]}")
        bones[name] = made
    _link(sections["hierarchy"], bones)
    length = _numbers(units.get("length", ["1"]), 1, 0)[0]
    if length <= 0.0:
        raise FormatError("the unit of length must be positive", place=":units")
    return AcclaimSkeleton(bones, channels, INCH / length)


def parse_motion(data: bytes, skeleton: AcclaimSkeleton) -> tuple[Nodes, float]:
    """Reads an AMC file for a skeleton: its nodes in the skeleton's unit, and frames per second. Raises FormatError."""
    lines = _text(data).splitlines()
    rows: dict[str, list[str]] = {name: [] for name, bone in skeleton.bones.items() if bone.dof}
    header = _take_even_frames(lines, rows)
    degrees, rate, frames, seen, number = True, RATE, -1, 0, 0  # seen: bones in the frame at hand
    for number, text in enumerate(lines[:header], 1):
        key, *values = text.split(None, 1) or ["#"]
        if key in rows and values and len(rows[key]) == frames:
            rows[key].append(values[0])
            seen += 1
        elif key.isdigit() and not values:
            _check_complete(rows, seen, frames, number)
            frames, seen = frames + 1, 0
        elif key.startswith(":"):
            degrees = degrees and key.upper() != ":RADIANS"
            rate = _numbers(values, 1, number)[0] if key.upper() == ":SAMPLES-PER-SECOND" else rate
        elif key in rows:
            wanted = f"one line with values for bone {key!r} in each frame"
            raise FormatError(f"{wanted} was expected", place=f"line {number}, frame {frames}")
        elif not key.startswith("#"):
            known = did_you_mean(key, rows)
            raise FormatError(f"the skeleton has no moving bone {key!r}", place=f"line {number}", mend=known)
    _check_complete(rows, seen, frames, number)
    if not rows["root"]:
        raise FormatError("it has no frames", mend=CUT_SHORT)
    if not 0.5 <= rate <= 1e4:
        raise FormatError(f"its rate is {rate} frames per second")
    values_of = {name: _values(name, texts, len(skeleton.bones[name].dof)) for name, texts in rows.items()}
    return _nodes(skeleton, values_of, degrees, len(data)), rate


def _take_even_frames(lines: list[str], rows: dict[str, list[str]]) -> int:
    """Fills in `rows` if every frame names the bones in one order, and returns how many lines come before the frames.

    Nearly all files do, and this takes a third of the time of going through them line by line, which is what is left
    to do for the others: all lines are returned.
    """
    starts = (number for number, text in enumerate(lines) if text.strip().isdigit())
    first, second = next(starts, len(lines)), next(starts, len(lines))
    frame, period = lines[first + 1 : second], second - first
    keys = [text.split(None, 1)[0] if text.strip() else "" for text in frame]
    if sorted(keys) != sorted(rows) or (len(lines) - first) % period:
        return len(lines)
    if not all(text.strip().isdigit() for text in lines[first::period]):
        return len(lines)
    taken = {}
    for place, key in enumerate(keys, 1):
        start, column = key + " ", lines[first + place :: period]
        if not all(text.startswith(start) for text in column):
            return len(lines)
        taken[key] = [text[len(start) :] for text in column]
    rows |= taken
    return first


def _text(data: bytes) -> str:
    if b"\0" in data:
        raise FormatError("this is a binary file, not Acclaim text")
    return data.decode("utf-8-sig", errors="replace")


def _lines(data: bytes) -> Iterator[tuple[int, list[str]]]:
    """Numbered lines as words, without comments and blank lines."""
    for number, text in enumerate(_text(data).splitlines(), 1):
        if (words := text.split()) and not words[0].startswith("#"):
            yield number, words


def _numbers(words: list[str], count: int, line: int) -> list[float]:
    try:
        values = [float(word) for word in words[:count]]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise FormatError(f"{count} finite numbers were expected", place=f"line {line}")
    return values


def _axes(words: list[str], degrees: bool, line: int) -> Floats:
    order = "".join(words[3:4]).lower() or "xyz"
    if sorted(order) != ["x", "y", "z"]:
        raise FormatError(f"{order!r} is no order of axes", place=f"line {line}")
    return _turns(order, np.array(_numbers(words, 3, line)), degrees)


def _turns(order: str, angles: Floats, degrees: bool) -> Floats:
    """Turns about fixed axes, the first in `order` first, by angles [..., n] -> [..., 4]."""
    halves = 0.5 * (np.radians(angles) if degrees else angles)[..., ::-1]
    return quaternion.from_euler(order[::-1], np.sin(halves), np.cos(halves))


def _bone_blocks(lines: list[tuple[int, list[str]]]) -> Iterator[dict[str, tuple[int, list[str]]]]:
    """The keys of each begin ... end block, with their lines."""
    block: dict[str, tuple[int, list[str]]] | None = None
    for number, words in lines:
        if words[0].lower() == "begin":
            block = {}
        elif words[0].lower() == "end" and block is not None:
            yield block
            block = None
        elif block is not None:
            block[words[0].lower()] = (number, words[1:])
    if block is not None:
        raise FormatError("a bone has no end", place=":bonedata", mend=CUT_SHORT)


def _bone(block: dict[str, tuple[int, list[str]]], degrees: bool) -> tuple[str, Bone]:
    if missing := [key for key in ("name", "direction", "length", "axis") if key not in block or not block[key][1]]:
        lines = [number for number, _ in block.values()]
        raise FormatError(f"a bone has no {missing[0]}", place=f"line {min(lines, default=0)}", mend=CUT_SHORT)
    name, dof = block["name"][1][0], tuple(word.lower() for word in block.get("dof", (0, []))[1])
    if unknown := [word for word in dof if word not in ("rx", "ry", "rz")]:
        raise FormatError(f"bone {name!r} has a degree of freedom {unknown[0]!r}; only rotations can be read")
    if len(set(dof)) != len(dof):
        raise FormatError(f"bone {name!r} has a degree of freedom twice")
    direction = np.array(_numbers(block["direction"][1], 3, block["direction"][0]))
    length = _numbers(block["length"][1], 1, block["length"][0])[0]
    return name, Bone(direction * length, _axes(block["axis"][1], degrees, block["axis"][0]), dof)


def _link(lines: list[tuple[int, list[str]]], bones: dict[str, Bone]) -> None:
    """Fills in the bones' children. Every bone hangs on exactly one other, and all on the root."""
    hung: set[str] = set()
    for number, words in lines:
        if words[0].lower() in ("begin", "end"):
            continue
        for name in words:
            if name not in bones:
                raise FormatError(f"unknown bone {name!r}", place=f"line {number}", mend=did_you_mean(name, bones))
        for child in words[1:]:
            if child in hung or child == "root" or (words[0] != "root" and words[0] not in hung):
                raise FormatError(f"bone {child!r} does not hang on the root by one way", place=f"line {number}")
            hung.add(child)
            bones[words[0]].children.append(child)
    if lost := sorted(set(bones) - hung - {"root"}):
        raise FormatError(f"bone {lost[0]!r} hangs on nothing", place=":hierarchy", mend=CUT_SHORT)


def _check_complete(rows: dict[str, list[str]], seen: int, frame: int, line: int) -> None:
    if frame >= 0 and seen < len(rows):
        missing = next(name for name, texts in rows.items() if len(texts) <= frame)
        raise FormatError(f"frame {frame} lacks bone {missing!r}", place=f"line {line}", mend=CUT_SHORT)


def _values(name: str, texts: list[str], width: int) -> Floats:
    """One bone's values [F, width]."""
    values = read_table("\n".join(texts), len(texts), width)
    if values is not None:
        return values
    for frame, text in enumerate(texts):
        place, words = f"frame {frame}, bone {name!r}", text.split()
        if len(words) != width:
            raise FormatError(f"{len(words)} values where its degrees of freedom need {width}", place=place)
        for word in words:
            if not _is_finite(word):
                raise FormatError(f"{word[:20]!r} is not a finite number", place=place)
    raise FormatError("its values cannot be read", place=f"bone {name!r}")


def _is_finite(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def _nodes(skeleton: AcclaimSkeleton, values: dict[str, Floats], degrees: bool, size: int) -> Nodes:
    ordered, bones = skeleton.nodes(), skeleton.bones
    frames = len(values["root"])
    rotations = still(frames, len(ordered), size)
    for place, (name, _) in enumerate(ordered):
        turns = [(column, channel[1]) for column, channel in enumerate(bones[name].dof) if channel[0] == "r"]
        if turns:
            order = "".join(axis for _, axis in turns)
            own = _turns(order, values[name][:, [column for column, _ in turns]], degrees)
            axes = bones[name].axes
            rotations[:, place] = quaternion.multiply(quaternion.multiply(axes, own), quaternion.conjugate(axes))
    columns = [skeleton.order.index(channel) for channel in ("tx", "ty", "tz")]
    tips = [place for place, (name, _) in enumerate(ordered) if not bones[name].children]
    return Nodes(
        names=tuple(name for name, _ in ordered),
        parents=np.array([parent for _, parent in ordered]),
        offsets=np.array([np.zeros(3) if parent < 0 else bones[ordered[parent][0]].tip for _, parent in ordered]),
        end_parents=np.array(tips, np.int64),
        end_offsets=np.array([bones[ordered[place][0]].tip for place in tips]).reshape(-1, 3),
        translations={0: values["root"][:, columns]},
        rotations=rotations,
    )
