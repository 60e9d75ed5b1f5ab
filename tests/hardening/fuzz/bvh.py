"""BVH files: joints, channels and frames by the grammar, with the liberties that exporters take, and damage."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from bench.hostile.damage import WORDS
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.bvh.hierarchy import CHANNELS
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make as make_clip
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw
from tests.hardening.fuzz.harness import write
from tests.hardening.fuzz.text import encoded, number, repeated

NAMES = ("Hips", "Spine", "LeftUpLeg", "LeftFoot", "Bone #1", "mixamorig:Hips", "左足", "a b", "{", "End", "", "0")
FRAMES = 8


@cache
def _sound() -> tuple[list[str], list[str]]:
    """Returns the lines of a sound hierarchy, and its rows of numbers."""
    text = dump_bvh(make_clip("walk", seed=1, seconds=1.0).frames(0, FRAMES)).decode()
    head, _, motion = text.partition("MOTION\n")
    return head.splitlines(), motion.splitlines()[2:]


def _channels(draw: Draw, words: list[str]) -> str:
    names = words[2:]
    if draw.rarely(25):
        names = draw.sample(CHANNELS, draw.randint(0, 6))
    if draw.rarely(80):
        names = [*names, draw.choice((*names, *CHANNELS, "Wrotation", "XROTATION"))]
    count = str(len(names)) if not draw.rarely(80) else number(draw, str(draw.randint(-1, 9)))
    return " ".join(["CHANNELS", count, *names])


def _hierarchy(draw: Draw) -> tuple[list[str], int]:
    """Returns the lines of a hierarchy, and the number of its channels."""
    lines: list[str] = []
    for line in _sound()[0]:
        words = line.split()
        if words[0] in ("JOINT", "ROOT") and draw.rarely(60):
            words[1] = draw.choice(NAMES)
        elif words[0] == "OFFSET":
            words[1:] = [number(draw, word) for word in words[1:]]
        elif words[0] == "CHANNELS":
            words = _channels(draw, words).split()
        elif draw.rarely(200):
            continue
        text = " ".join(words)
        if draw.rarely(60):
            text = draw.choice(
                (f"{text} // {text}", f"{text} }}", f"{{ {text}", text.lower(), f"# {text}", f"\t{text}")
            )
        lines += repeated(draw, [text])
    if draw.rarely(60):  # a chain, as deep as it may be
        deep = draw.choice((2, 50, 1500))
        chain = [f"JOINT chain{at}\n{{\nOFFSET 0 0 0\nCHANNELS 0" for at in range(deep)] + ["}"] * deep
        at = draw.randrange(len(lines) + 1)
        lines[at:at] = chain
    return lines, sum(len(re.findall(r"(?i)[xyz](?:rotation|position)", line)) for line in lines)


def _rows(draw: Draw, width: int) -> list[str]:
    rows: list[str] = []
    for row in _sound()[1]:
        words = (row.split() * (1 + width // max(1, len(row.split()))))[:width]
        if draw.rarely(4):
            words[draw.randrange(len(words) + 1) :] = words[: draw.randrange(len(words) + 1)]
        if draw.rarely(4) and words:
            at = draw.randrange(len(words))
            words[at] = draw.choice((*WORDS, "1,5", "1.5", "7", "//", "2;3"))
        text = (draw.choice(("\t", "\n", ", ", "  ")) if draw.rarely(4) else " ").join(words)
        rows += repeated(draw, [text])
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
    write(files, folder)
    read_clip(folder / "clip.bvh")


EARLY = re.compile("expected HIERARCHY|the file is empty|this is a binary|the file ends inside the hierarchy")
DOOR = Door(make, enter, EARLY)
