"""Reads Acclaim skeletons (ASF).

A bone's joint is where the bone begins, as in the BVH conversions of the database. A bone rotates by R about axes of
its own, C. Its rotation in the parent's frame is C R C^-1, so local frames are aligned with the world in the bind pose.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError, did_you_mean
from motionsplice.motion.formats.text import text_of, with_points
from motionsplice.motion.quaternion import Floats

INCH = 0.0254  # metres; the unit of an ASF file is 1 inch divided by its `length`
CUT_SHORT = "Export or download the file again; it may be cut short"


@dataclass
class Bone:
    """A bone: from its joint to its tip in the bind pose [3], in the file's unit; its channels.

    Its axes are turned by angles [3] about X, Y and Z, the first letter of `order` first.
    """

    tip: Floats
    order: str
    angles: list[float]
    dof: tuple[str, ...]
    children: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class AcclaimSkeleton:
    """The contents of an ASF file.

    `axes` are the axes C [4] of each bone. `order` lists the root's channels; `unit` is in metres, None if it is not
    stated.
    """

    bones: dict[str, Bone]
    axes: Mapping[str, Floats]
    order: tuple[str, ...]
    unit: float | None

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
    for name in ("root", "bonedata", "hierarchy"):
        if name not in sections:
            raise FormatError(f"the file has no :{name} section", mend=CUT_SHORT)
    units = {words[0].lower(): words[1:] for _, words in sections.get("units", [])}
    root = {words[0].lower(): (number, words[1:]) for number, words in sections["root"]}
    degrees = not (units.get("angle") or ["deg"])[0].lower().startswith("rad")
    number, order = root.get("order", (0, []))
    channels = tuple(word.lower() for word in order)
    if sorted(channels) != ["rx", "ry", "rz", "tx", "ty", "tz"]:
        problem = "the root's order must list TX, TY, TZ, RX, RY and RZ once each"
        raise FormatError(problem, place=f"line {number}" if number else ":root")
    axis = root.get("axis", (0, ["XYZ"]))[1]
    number, orientation = root.get("orientation", (0, ["0", "0", "0"]))
    bones = {"root": Bone(np.zeros(3), *_axes([*orientation, *axis], number), channels)}
    for bone in _bone_blocks(sections["bonedata"]):
        name, parsed = _bone(bone)
        if name in bones:
            problem = f"two bones have the name {name!r}"
            raise FormatError(problem, place=f"line {bone['name'][0]}", mend="Rename one of them")
        bones[name] = parsed
    _link(sections["hierarchy"], bones)
    length = numbers(units["length"], 1, 0)[0] if "length" in units else None
    if length is not None and length <= 0.0:
        raise FormatError("the unit of length must be positive", place=":units")
    return AcclaimSkeleton(bones, _turned(bones, degrees), channels, INCH / length if length else None)


def _lines(data: bytes) -> Iterator[tuple[int, list[str]]]:
    """Yields each line as its number and words, without comments and blank lines."""
    for number, text in enumerate(text_of(data, CUT_SHORT).splitlines(), 1):
        if (words := text.split()) and not words[0].startswith("#"):
            yield number, words


def spellings(bones: Iterable[str]) -> dict[str, str]:
    """Returns the bones' names by their names, and by their names in lower case."""
    names = list(bones)
    return {name.lower(): name for name in reversed(names)} | {name: name for name in names}


def spelled(name: str, spelling: Mapping[str, str]) -> str:
    """Returns a bone's name as the skeleton spells it, which may differ in upper and lower case."""
    return spelling.get(name) or spelling.get(name.lower(), name)


def numbers(words: list[str], count: int, line: int) -> list[float]:
    try:
        values = [float(word) for word in with_points(" ".join(words[:count])).split()]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        expected = "a finite number" if count == 1 else f"{count} finite numbers"
        raise FormatError(f"expected {expected}, found {' '.join(words)[:40]!r}", place=f"line {line}")
    return values


def _axes(words: list[str], line: int) -> tuple[str, list[float]]:
    """Returns the order and the angles of axes."""
    order = "".join(words[3:4]).lower() or "xyz"
    if sorted(order) != ["x", "y", "z"]:
        problem = f"{order[:20]!r} is not an order of axes"
        raise FormatError(problem, place=f"line {line}", mend="Use X, Y and Z once each")
    return order, numbers(words, 3, line)


def _turned(bones: Mapping[str, Bone], degrees: bool) -> dict[str, Floats]:
    """Returns the axes [4] of all bones, those of one order at once."""
    axes: dict[str, Floats] = {}
    for order in {bone.order for bone in bones.values()}:
        names = [name for name, bone in bones.items() if bone.order == order]
        turned = about_axes(order, np.array([bones[name].angles for name in names]), degrees)
        axes |= zip(names, turned, strict=True)
    return axes


def about_axes(order: str, angles: Floats, degrees: bool) -> Floats:
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


def _bone(block: dict[str, tuple[int, list[str]]]) -> tuple[str, Bone]:
    if missing := [key for key in ("name", "direction", "length", "axis") if key not in block or not block[key][1]]:
        lines = [number for number, _ in block.values()]
        raise FormatError(f"a bone has no {missing[0]}", place=f"line {min(lines, default=0)}", mend=CUT_SHORT)
    name, dof = block["name"][1][0], tuple(word.lower() for word in block.get("dof", (0, []))[1])
    if unknown := [word for word in dof if word not in ("rx", "ry", "rz")]:
        problem = f"bone {name!r} has degree of freedom {unknown[0]!r}, which is not supported"
        raise FormatError(problem, mend="Use rx, ry and rz only")
    if len(set(dof)) != len(dof):
        raise FormatError(f"bone {name!r} lists a degree of freedom twice")
    direction = np.array(numbers(block["direction"][1], 3, block["direction"][0]))
    length = numbers(block["length"][1], 1, block["length"][0])[0]
    return name, Bone(direction * length, *_axes(block["axis"][1], block["axis"][0]), dof)


def _link(lines: list[tuple[int, list[str]]], bones: dict[str, Bone]) -> None:
    """Fills in the bones' children. Raises FormatError unless they form one tree below the root."""
    linked: set[str] = set()
    spelling = spellings(bones)
    for number, words in lines:
        if words[0].lower() in ("begin", "end"):
            continue
        words = [spelled(name, spelling) for name in words]
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
