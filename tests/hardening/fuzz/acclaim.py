"""ASF skeletons with AMC motions: sections, bones and frames by the grammar, and damage."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from bench.hostile.good_files import good_files
from motionsplice.motion.clip_settings import ClipSettings
from motionsplice.motion.formats.files import read_bytes
from motionsplice.motion.formats.reading import read_as
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw
from tests.hardening.fuzz.held import held
from tests.hardening.fuzz.text import encoded, odd_number, repeated

KEYS = (":units", ":root", ":bonedata", ":hierarchy", ":DEGREES", ":RADIANS", ":FULLY-SPECIFIED", ":name", ":", "begin")
WORDS = ("root", "rx", "ry", "rz", "tx", "TX", "l", "XYZ", "XXX", "ZYX", "begin", "end", "deg", "rad", "", "#", "Head")
NUMBER = re.compile(r"[-+]?\d[\d.]*$")
FRAMES = 2
NAMES = ("clip.amc", "clip.asf")


@cache
def _sound() -> tuple[list[str], list[str]]:
    """Returns the lines of a sound motion and of its skeleton."""
    (good,) = good_files("amc", None)
    motion, skeleton = (data.decode().splitlines() for data in good.files.values())
    return motion[: motion.index(str(1 + FRAMES))], skeleton


def _odd_line(draw: Draw, line: str) -> list[str]:
    """Returns what may stand in place of a line."""
    words, kind = line.split() or [""], draw.randrange(8)
    at = draw.randrange(len(words))
    if kind <= 2:
        numbers = [place for place, word in enumerate(words) if NUMBER.match(word)] or [at]
        words[draw.choice(numbers)] = odd_number(draw)
    elif kind == 3:
        words[at] = draw.choice((*WORDS, *KEYS))
    elif kind == 4:
        words = draw.choice((words[:-1], words[1:], [*words, draw.choice(WORDS)], words[:1], words * 2))
    elif kind == 5:
        return []
    elif kind == 6:
        return repeated(draw, [line])
    else:
        return [line, draw.choice((*KEYS, "# a comment", "", "end"))]
    return [" ".join(words)]


def _changed(draw: Draw, sound: list[str]) -> list[str]:
    lines = list(sound)
    for _ in range(draw.few()):
        at = draw.randrange(len(lines))
        lines[at : at + 1] = _odd_line(draw, lines[at])
    return lines


def make(draw: Draw) -> Files:
    """Returns a motion and its skeleton."""
    return {name: encoded(draw, _changed(draw, lines)) for name, lines in zip(NAMES, _sound(), strict=True)}


def enter(files: Files, folder: Path) -> None:
    """Reads the files as a clip."""
    places = held(files, folder)
    read_as(ClipSettings(), places[NAMES[0]], None, read=lambda place: read_bytes(places[place.name]))


EARLY = re.compile("the file is empty|this is a binary|the file has no :")
DOOR = Door(make, enter, EARLY)
