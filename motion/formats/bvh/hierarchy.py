"""The hierarchy of a BVH file, parsed line by line, without recursion."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from motionsplice.motion.errors import FormatError
from motionsplice.motion.formats.decimals import is_finite
from motionsplice.motion.formats.names import numbered
from motionsplice.motion.formats.text import COMMAS, with_points
from motionsplice.motion.role_names import roles_by_name

CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")
CUT_SHORT = "Export the file again; it may be cut short"
COMMENT = re.compile(r"^\s*#.*|(?:^|\s)(?://|;|#(?!\d)).*")  # a name may be "Bone #1"
PART = re.compile(r"[{}]|[^{}]+")
END_SITES = ("END", "ENDSITE", "SITE")


@dataclass
class Joint:
    """A joint or an end site. end: the index after its last descendant, in the list of all joints and end sites."""

    name: str
    parent: int
    line: int
    offset: list[float] = field(default_factory=list)
    channels: list[str] | None = None
    is_end: bool = False
    end: int = 0


@dataclass(frozen=True)
class Hierarchy:
    """All joints and end sites, depth first; the index of the line with MOTION; notes. Files of one rig share it."""

    joints: tuple[Joint, ...]
    line: int
    notes: tuple[str, ...]


def read_hierarchy(lines: list[str]) -> Hierarchy:
    """Parses the lines up to MOTION. Raises FormatError, which names the line."""
    joints: list[Joint] = []
    open_joints: list[int] = []  # joints whose brace is open
    started = waiting = commas = False  # waiting: the next word must be an opening brace
    before: tuple[str, str] | None = None  # where the first words are that precede HIERARCHY: comments of any form
    for number, (word, *rest) in _statements(lines):
        place = f"line {number + 1}"
        match word.upper():
            case "HIERARCHY" if not started:
                started = True
            case _ if not started:
                before = before or (place, " ".join([word, *rest])[:40])
            case "ROOT" | "JOINT" | "END" | "ENDSITE" | "SITE" as kind if not waiting:
                joints.append(_opened(kind, " ".join(rest), joints, open_joints, number + 1))
                waiting = True
            case "{" if waiting:
                open_joints.append(len(joints) - 1)
                waiting = False
            case "}" if open_joints and not waiting:
                joint = joints[open_joints.pop()]
                joint.end = len(joints)
                if not joint.offset:
                    raise FormatError(f"joint {joint.name!r} has no OFFSET", place=place)
            case "OFFSET" if open_joints and not waiting:
                text = " ".join(rest)
                joints[open_joints[-1]].offset = _offset(text, place)
                commas = commas or ("," in text and len(text.split()) == 3 and "." not in text)
            case "CHANNELS" if open_joints and not waiting:
                _give_channels(joints[open_joints[-1]], _channels(rest, place), place)
            case "MOTION" if joints and not open_joints and not waiting:
                notes = (COMMAS,) * commas
                notes += (f"left out what precedes HIERARCHY: {before[1]!r}",) if before else ()
                return Hierarchy(tuple(joints), number, notes)
            case _:
                raise FormatError(f"unexpected {' '.join([word, *rest])[:40]!r}", place=place)
    if before and not started:
        problem = f"expected HIERARCHY, the first word of a BVH file, found {before[1]!r}"
        raise FormatError(problem, place=before[0], mend="Export the motion as BVH")
    raise FormatError("the file ends inside the hierarchy, before MOTION", place=f"line {len(lines)}", mend=CUT_SHORT)


def _statements(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Yields each statement as its line index and words, without comments. A brace is a statement of its own."""
    for number, text in enumerate(lines):
        if "#" in text or "/" in text or ";" in text:
            text = COMMENT.sub("", text)
        for part in PART.findall(text) if "{" in text or "}" in text else (text,):
            if words := part.split():
                yield number, words


def _opened(kind: str, name: str, joints: list[Joint], open_joints: list[int], line: int) -> Joint:
    """Returns the joint or end site that a line opens. Raises FormatError if it may not stand there."""
    is_end, is_root = kind in END_SITES, kind == "ROOT"
    if (is_root and open_joints) or not (is_root or joints) or not (is_end or name):
        raise FormatError("expected a ROOT with named JOINTs below it", place=f"line {line}")
    if not is_root and not open_joints:
        raise FormatError("a joint is outside the ROOT's braces", place=f"line {line}")
    parent = open_joints[-1] if open_joints else -1
    if parent >= 0 and joints[parent].is_end:
        raise FormatError("an End Site cannot have children", place=f"line {line}")
    return Joint(name, parent, line, is_end=is_end)


def _give_channels(joint: Joint, channels: list[str], place: str) -> None:
    if joint.channels is not None:
        raise FormatError(f"joint {joint.name!r} has a second CHANNELS line", place=place)
    if joint.is_end and channels:
        raise FormatError("an End Site cannot have CHANNELS", place=place, mend="Make it a JOINT")
    joint.channels = channels


def _offset(text: str, place: str) -> list[float]:
    for words in (with_points(text).split(), text.replace(",", " ").split()):  # commas may separate the numbers
        if len(words) == 3 and all(map(is_finite, words)):
            return [float(word) for word in words]
    raise FormatError(f"OFFSET needs three finite numbers, found {text[:40]!r}", place=place)


def _channels(words: list[str], place: str) -> list[str]:
    channels = [word.capitalize() for word in words[1:]]
    if not words or words[0] != str(len(channels)):
        declared = words[0][:20] if words else "nothing"
        raise FormatError(f"CHANNELS declares {declared}, but names {len(channels)} channels", place=place)
    if unknown := [word for word in channels if word not in CHANNELS]:
        raise FormatError(f"unknown channel {unknown[0]!r}", place=place, mend=f"Use {', '.join(CHANNELS)}")
    if len(set(channels)) != len(channels):
        raise FormatError("CHANNELS lists a channel twice", place=place)
    return channels


def number_doubles(joints: list[Joint], places: list[int]) -> list[str]:
    """Numbers names that come twice at these places of a list of joints. Returns the new names."""
    unique = numbered([joints[place].name for place in places])
    renamed = [(place, name) for place, name in zip(places, unique, strict=True) if joints[place].name != name]
    for place, name in renamed:
        joints[place] = replace(joints[place], name=name)
    return [name for _, name in renamed]


def check_doubles(joints: list[Joint], root: int) -> None:
    """Raises FormatError if two joints of a body have a name that means a role, and neither is below the other."""
    body = [place for place in range(root, joints[root].end) if not joints[place].is_end]
    names = tuple(joints[place].name for place in body)
    if len(set(names)) == len(names):
        return
    roles = {joint: role for role, joint in roles_by_name(names).items()}
    first: dict[str, int] = {}
    for number, place in enumerate(body):
        other = first.setdefault(names[number], number)
        role, upper, lower = roles.get(other, ""), joints[body[other]], joints[place]
        if other != number and role and place >= upper.end:
            problem = f"two joints are named {lower.name!r}, on lines {upper.line} and {lower.line}"
            which = role.replace("_", " ")
            raise FormatError(f"{problem}: it is unclear which is the {which}", mend="Rename one of them")
