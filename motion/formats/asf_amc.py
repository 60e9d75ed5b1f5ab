"""Reads Acclaim skeletons (ASF) and motions (AMC), such as those of the CMU database.

A bone's joint is where the bone begins, as in the BVH conversions of the database. A bone rotates by R about axes of
its own, C. Its rotation in the parent's frame is C R C^-1, so local frames are aligned with the world in the bind pose.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError, did_you_mean
from motionsplice.motion.formats.decimals import is_finite, read_table
from motionsplice.motion.formats.fold import Nodes, still
from motionsplice.motion.quaternion import Floats

INCH = 0.0254  # metres; the unit of an ASF file is 1 inch divided by its `length`
RATE = 120.0  # frames per second, unless the file says otherwise
CUT_SHORT = "Export or download the file again; it may be cut short"


@dataclass
class Bone:
    """A bone: from its joint to its tip in the bind pose [3], in the file's unit; its axes C [4]; its channels."""

    tip: Floats
    axes: Floats
    dof: tuple[str, ...]
    children: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class AcclaimSkeleton:
    """The contents of an ASF file. `order` lists the root's channels; `unit` is in metres."""

    bones: dict[str, Bone]
    order: tuple[str, ...]
    unit: float

    def nodes(self) -> list[tuple[str, int]]:
        """Returns all joints, depth first, each with the place of its parent in this list."""
        ordered: list[tuple[str, int]] = []
        pending = [("root", -1)]
        while pending:
            name, parent = pending.pop()
            ordered.append((name, parent))
            pending += [(child, len(ordered) - 1) for child in reversed(self.bones[name].children)]
        return ordered


def parse_skeleton(data: bytes) -> AcclaimSkeleton:
    """Parses an ASF file. Raises FormatError, which names the line or section."""
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
            raise FormatError(f"the file has no :{name} section", mend=CUT_SHORT)
    units = {words[0].lower(): words[1:] for _, words in sections["units"]}
    root = {words[0].lower(): (number, words[1:]) for number, words in sections["root"]}
    degrees = not (units.get("angle") or ["deg"])[0].lower().startswith("rad")
    number, order = root.get("order", (0, []))
    channels = tuple(word.lower() for word in order)
    if sorted(channels) != ["rx", "ry", "rz", "tx", "ty", "tz"]:
        problem = "the root's order must list TX, TY, TZ, RX, RY and RZ once each"
        raise FormatError(problem, place=f"line {number}")
    axis = root.get("axis", (0, ["XYZ"]))[1]
    number, orientation = root.get("orientation", (0, ["0", "0", "0"]))
    bones = {"root": Bone(np.zeros(3), _axes([*orientation, *axis], degrees, number), channels)}
    for bone in _bone_blocks(sections["bonedata"]):
        name, parsed = _bone(bone, degrees)
        if name in bones:
            problem = f"two bones have the name {name!r}"
            raise FormatError(problem, place=f"line {bone['name'][0]}", mend="Rename one of them")
        bones[name] = parsed
    _link(sections["hierarchy"], bones)
    length = _numbers(units.get("length", ["1"]), 1, 0)[0]
    if length <= 0.0:
        raise FormatError("the unit of length must be positive", place=":units")
    return AcclaimSkeleton(bones, channels, INCH / length)


def parse_motion(data: bytes, skeleton: AcclaimSkeleton) -> tuple[Nodes, float]:
    """Parses an AMC file: its nodes, in the skeleton's unit, and its frames per second.

    Raises FormatError, which names the line or the frame and bone.
    """
    lines = _text(data).splitlines()
    rows: dict[str, list[str]] = {name: [] for name, bone in skeleton.bones.items() if bone.dof}
    header = _take_even_frames(lines, rows)
    degrees, rate, frames, seen, number = True, RATE, -1, 0, 0  # seen: bones in the current frame
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
            problem = f"expected one line with values for bone {key!r} in each frame"
            raise FormatError(problem, place=f"line {number}, frame {frames}")
        elif not key.startswith("#"):
            problem = f"the skeleton has no moving bone {key!r}"
            raise FormatError(problem, place=f"line {number}", mend=did_you_mean(key, rows))
    _check_complete(rows, seen, frames, number)
    if not rows["root"]:
        raise FormatError("the file has no frames", mend=CUT_SHORT)
    if not 0.5 <= rate <= 1e4:
        problem = f"the rate is invalid: {rate:g} frames per second"
        raise FormatError(problem, mend="Set :SAMPLES-PER-SECOND to 0.5 to 10000")
    values_of = {name: _values(name, texts, len(skeleton.bones[name].dof)) for name, texts in rows.items()}
    return _nodes(skeleton, values_of, degrees, len(data)), rate


def _take_even_frames(lines: list[str], rows: dict[str, list[str]]) -> int:
    """Fills in `rows` if all frames list the bones in the same order. Returns the number of lines still to be parsed.

    Those are the header's lines if it succeeds, as it does for nearly all files, in a third of the time of parsing line
    by line. Otherwise they are all lines.
    """
    starts = (number for number, text in enumerate(lines) if text.strip().isdigit())
    first, second = next(starts, len(lines)), next(starts, len(lines))
    frame, period = lines[first + 1 : second], second - first
    keys = [text.split(None, 1)[0] if text.strip() else "" for text in frame]
    if sorted(keys) != sorted(rows) or (len(lines) - first) % period:
        return len(lines)
    if not all(text.strip().isdigit() for text in lines[first::period]):
        return len(lines)
    columns = {}
    for place, key in enumerate(keys, 1):
        start, column = key + " ", lines[first + place :: period]
        if not all(text.startswith(start) for text in column):
            return len(lines)
        columns[key] = [text[len(start) :] for text in column]
    rows |= columns
    return first


def _text(data: bytes) -> str:
    if b"\0" in data:
        raise FormatError("this is a binary file, not Acclaim text")
    return data.decode("utf-8-sig", errors="replace")


def _lines(data: bytes) -> Iterator[tuple[int, list[str]]]:
    """Yields each line as its number and words, without comments and blank lines."""
    for number, text in enumerate(_text(data).splitlines(), 1):
        if (words := text.split()) and not words[0].startswith("#"):
            yield number, words


def _numbers(words: list[str], count: int, line: int) -> list[float]:
    try:
        values = [float(word) for word in words[:count]]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        expected = "a finite number" if count == 1 else f"{count} finite numbers"
        raise FormatError(f"expected {expected}, found {' '.join(words)[:40]!r}", place=f"line {line}")
    return values


def _axes(words: list[str], degrees: bool, line: int) -> Floats:
    order = "".join(words[3:4]).lower() or "xyz"
    if sorted(order) != ["x", "y", "z"]:
        problem = f"{order[:20]!r} is not an order of axes"
        raise FormatError(problem, place=f"line {line}", mend="Use X, Y and Z once each")
    return _turns(order, np.array(_numbers(words, 3, line)), degrees)


def _turns(order: str, angles: Floats, degrees: bool) -> Floats:
    """Returns the rotations by angles [..., n] about fixed axes, the first of `order` first. -> [..., 4]."""
    halves = 0.5 * (np.radians(angles) if degrees else angles)[..., ::-1]
    return quaternion.from_euler(order[::-1], np.sin(halves), np.cos(halves))


def _bone_blocks(lines: list[tuple[int, list[str]]]) -> Iterator[dict[str, tuple[int, list[str]]]]:
    """Yields each begin ... end block as its keys, each with its line number and words."""
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
        raise FormatError("the last bone has no 'end' line", place=":bonedata", mend=CUT_SHORT)


def _bone(block: dict[str, tuple[int, list[str]]], degrees: bool) -> tuple[str, Bone]:
    if missing := [key for key in ("name", "direction", "length", "axis") if key not in block or not block[key][1]]:
        lines = [number for number, _ in block.values()]
        raise FormatError(f"a bone has no {missing[0]}", place=f"line {min(lines, default=0)}", mend=CUT_SHORT)
    name, dof = block["name"][1][0], tuple(word.lower() for word in block.get("dof", (0, []))[1])
    if unknown := [word for word in dof if word not in ("rx", "ry", "rz")]:
        problem = f"bone {name!r} has degree of freedom {unknown[0]!r}, which is not supported"
        raise FormatError(problem, mend="Use rx, ry and rz only")
    if len(set(dof)) != len(dof):
        raise FormatError(f"bone {name!r} lists a degree of freedom twice")
    direction = np.array(_numbers(block["direction"][1], 3, block["direction"][0]))
    length = _numbers(block["length"][1], 1, block["length"][0])[0]
    return name, Bone(direction * length, _axes(block["axis"][1], degrees, block["axis"][0]), dof)


def _link(lines: list[tuple[int, list[str]]], bones: dict[str, Bone]) -> None:
    """Fills in the bones' children. Raises FormatError unless they form one tree below the root."""
    linked: set[str] = set()
    for number, words in lines:
        if words[0].lower() in ("begin", "end"):
            continue
        for name in words:
            if name not in bones:
                raise FormatError(f"unknown bone {name!r}", place=f"line {number}", mend=did_you_mean(name, bones))
        for child in words[1:]:
            if child in linked or child == "root" or (words[0] != "root" and words[0] not in linked):
                problem = f"bone {child!r} must have exactly one parent, which is listed before it"
                raise FormatError(problem, place=f"line {number}")
            linked.add(child)
            bones[words[0]].children.append(child)
    if orphans := sorted(set(bones) - linked - {"root"}):
        raise FormatError(f"bone {orphans[0]!r} has no parent", place=":hierarchy", mend=CUT_SHORT)


def _check_complete(rows: dict[str, list[str]], seen: int, frame: int, line: int) -> None:
    if frame >= 0 and seen < len(rows):
        missing = next(name for name, texts in rows.items() if len(texts) <= frame)
        raise FormatError(f"frame {frame} has no values for bone {missing!r}", place=f"line {line}", mend=CUT_SHORT)


def _values(name: str, texts: list[str], width: int) -> Floats:
    """Parses one bone's values [F, width]."""
    values = read_table("\n".join(texts), len(texts), width)
    if values is not None:
        return values
    for frame, text in enumerate(texts):
        place, words = f"frame {frame}, bone {name!r}", text.split()
        if len(words) != width:
            problem = f"expected {width} values, one for each degree of freedom, found {len(words)}"
            raise FormatError(problem, place=place)
        for word in words:
            if not is_finite(word):
                raise FormatError(f"{word[:20]!r} is not a finite number", place=place)
    raise FormatError("expected plain decimal numbers", place=f"bone {name!r}")


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
