"""ASF skeletons with AMC motions: sections, bones and frames by the grammar, and damage."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from bench.hostile.good_files import good_files
from motionsplice.motion.formats.reading import read_clip
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw
from tests.hardening.fuzz.harness import write
from tests.hardening.fuzz.text import encoded, number, repeated

KEYS = (":units", ":root", ":bonedata", ":hierarchy", ":DEGREES", ":RADIANS", ":FULLY-SPECIFIED", ":name", ":", "begin")
WORDS = ("root", "rx", "ry", "rz", "tx", "TX", "l", "XYZ", "XXX", "ZYX", "begin", "end", "deg", "rad", "", "#", "Head")
NUMBER = re.compile(r"[-+]?\d[\d.]*$")
NAMES = ("clip.amc", "clip.asf")


@cache
def _sound() -> tuple[list[str], list[str]]:
    """Returns the lines of a sound motion and of its skeleton."""
    (good,) = good_files("amc", None)
    motion, skeleton = (data.decode().splitlines() for data in good.files.values())
    return motion, skeleton


def _changed(draw: Draw, lines: list[str]) -> list[str]:
    changed: list[str] = []
    for line in lines:
        words = [number(draw, word) if NUMBER.match(word) else word for word in line.split()]
        if words and draw.rarely(120):
            words[draw.randrange(len(words))] = draw.choice((*WORDS, *KEYS))
        if draw.rarely(120):
            words = draw.choice((words[:-1], words[1:], [*words, draw.choice(WORDS)], words[:1], words * 2))
        if not draw.rarely(200):
            changed += repeated(draw, [" ".join(words)])
        if draw.rarely(200):
            changed.append(draw.choice((*KEYS, "# a comment", "", "end")))
    return changed


def make(draw: Draw) -> Files:
    """Returns a motion and its skeleton."""
    return {name: encoded(draw, _changed(draw, lines)) for name, lines in zip(NAMES, _sound(), strict=True)}


def enter(files: Files, folder: Path) -> None:
    """Reads the files as a clip."""
    write(files, folder)
    read_clip(folder / NAMES[0])


EARLY = re.compile("the file is empty|this is a binary|the file has no :")
DOOR = Door(make, enter, EARLY)
