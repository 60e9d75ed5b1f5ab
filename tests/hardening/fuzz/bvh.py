"""BVH files: joints, channels and frames by the grammar, with the liberties that exporters take, and damage."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from bench.hostile.damage import WORDS
from bench.hostile.small_rig import on_few_joints
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.bvh.hierarchy import CHANNELS
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make as make_clip
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw
from tests.hardening.fuzz.held import held
from tests.hardening.fuzz.text import encoded, number, odd_number, repeated

NAMES = ("Hips", "Spine", "LeftUpLeg", "LeftFoot", "Bone #1", "mixamorig:Hips", "左足", "a b", "{", "End", "", "0")
FRAMES = 4
CHANNEL = re.compile("(?i)[xyz](?:rotation|position)")


@cache
def _sound() -> tuple[list[str], list[str]]:
    """Returns the lines of a sound hierarchy, and its rows of numbers."""
    text = dump_bvh(on_few_joints(make_clip("walk", seed=1, seconds=1.0).frames(0, FRAMES))).decode()
    head, _, motion = text.partition("MOTION\n")
    return [line.strip() for line in head.splitlines()], motion.splitlines()[2:]


def _channels(draw: Draw, names: list[str]) -> str:
    kind = draw.randrange(3)
    if kind == 0:
        names = draw.sample(CHANNELS, draw.randint(0, 6))
    elif kind == 1:
        names = [*names, draw.choice((*names, *CHANNELS, "Wrotation", "XROTATION"))]
    count = str(len(names)) if kind < 2 else odd_number(draw)
    return " ".join(["CHANNELS", count, *names])


def _odd_line(draw: Draw, line: str) -> list[str]:
    """Returns what may stand in place of a line of the hierarchy."""
    first, *others = line.split() or [""]
    kind = draw.randrange(8)
    if kind == 0:
        return []
    if kind == 1:
        return repeated(draw, [line])
    if kind == 2:
        return [draw.choice((f"{line} // {line}", f"{line} }}", f"{{ {line}", line.lower(), f"# {line}", f"\t{line}"))]
    if first in ("JOINT", "ROOT"):
        return [f"{first} {draw.choice(NAMES)}"]
    if first == "CHANNELS":
        return [_channels(draw, others[1:])]
    if first == "OFFSET" and others:
        others[draw.randrange(len(others))] = odd_number(draw)
        return [" ".join((first, *others))]
    return [line, draw.choice(("{", "}", "End Site", "JOINT x", "OFFSET 1 2 3", "MOTION"))]


def _hierarchy(draw: Draw) -> tuple[list[str], int]:
    """Returns the lines of a hierarchy, and the number of its channels."""
    lines = list(_sound()[0])
    for _ in range(draw.few()):
        at = draw.randrange(len(lines))
        lines[at : at + 1] = _odd_line(draw, lines[at]) or [""]
    if draw.rarely(60):  # a chain, as deep as it may be
        deep = draw.choice((2, 10, 10, 300))
        chain = [f"JOINT chain{at}\n{{\nOFFSET 0 0 0\nCHANNELS 0" for at in range(deep)] + ["}"] * deep
        at = draw.randrange(len(lines) + 1)
        lines[at:at] = chain
    return lines, len(CHANNEL.findall("\n".join(lines)))


def _odd_row(draw: Draw, row: str) -> list[str]:
    words, kind = row.split() or [""], draw.randrange(5)
    at = draw.randrange(len(words))
    if kind == 0:
        return repeated(draw, [row])
    if kind == 1:
        words[at:] = words[: draw.randrange(len(words) + 1)]
    elif kind == 2:
        words[at] = draw.choice((*WORDS, "1,5", "1.5", "7", "//", "2;3"))
    elif kind == 3:
        return [draw.choice(("\t", "\n", ", ", "  ")).join(words)]
    return [" ".join(words)]


def _rows(draw: Draw, width: int) -> list[str]:
    rows = list(_sound()[1])
    words = rows[0].split()
    if width != len(words):
        rows = [" ".join((words * (1 + width // len(words)))[:width])] * len(rows)
    for _ in range(draw.few()):
        at = draw.randrange(len(rows))
        rows[at : at + 1] = _odd_row(draw, rows[at])
    return [row.replace(".", ",") for row in rows] if draw.rarely(20) else rows


def make(draw: Draw) -> Files:
    """Returns a BVH file."""
    lines, width = _hierarchy(draw)
    rows = _rows(draw, width)
    count = number(draw, str(len(rows) if not draw.rarely(8) else draw.randint(-1, 40)))
    header = [f"Frames: {count}", f"Frame Time: {number(draw, '0.0333333')}"]
    if draw.rarely(20):
        header = draw.choice(([" ".join(header)], header[::-1], header[:1], ["Frames 8", "frame_time = 0,04"]))
    before = [draw.choice(("// exported", "x", "", "\ufeff"))] if draw.rarely(40) else []
    after = [draw.choice(("end", "// the end", "1 2 3", "MOTION", "}"))] if draw.rarely(40) else []
    motion = [] if draw.rarely(200) else ["MOTION"]
    ending = draw.choice(("", "\r\n", "\0\0\0\x1a", " \n\n")) if draw.rarely(8) else "\n"
    return {"clip.bvh": encoded(draw, [*before, *lines, *motion, *header, *rows, *after], ending)}


def enter(files: Files, folder: Path) -> None:
    """Reads the file as a clip."""
    read_clip(held(files, folder)["clip.bvh"])


EARLY = re.compile("expected HIERARCHY|the file is empty|this is a binary|the file ends inside the hierarchy")
DOOR = Door(make, enter, EARLY)
