"""The MOTION part of a BVH file: its header and its frames."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from motionsplice.motion.errors import FormatError
from motionsplice.motion.formats.bvh.hierarchy import COMMENT, CUT_SHORT
from motionsplice.motion.formats.decimals import as_bytes, is_finite, read_table
from motionsplice.motion.formats.text import COMMAS, with_points
from motionsplice.motion.quaternion import Floats

SHORTEST_STEP, LONGEST_STEP = 1e-4, 2.0  # seconds per frame
FIELD = re.compile(r"(frames|frame[ _]?time) ?[:=]? ?(\S+) ?", re.IGNORECASE)
NUMBER = re.compile(r"\s*([-+.\d]|nan|inf)", re.IGNORECASE)  # the start of a row of numbers, even of bad ones

Row = tuple[int, str]  # the line's number, from 1, and its text


@dataclass(frozen=True)
class Header:
    """The frames that the header declares, the digits of its frame time, and the index of the line after it."""

    count: int
    step: str
    end: int


@dataclass(frozen=True)
class Frames:
    """All channel values [F, width], and what the user should know of how they were read."""

    values: Floats
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def read_header(lines: list[str], line: int) -> Header:
    """Parses the header after the line with MOTION. Raises FormatError, which names the line."""
    found: dict[str, str] = {}
    for number in range(line + 1, len(lines)):
        text = " ".join(COMMENT.sub("", lines[number]).split())
        if not text:
            continue
        fields = {
            "frames" if match[1].lower() == "frames" else "step": with_points(match[2])
            for match in FIELD.finditer(text)
        }
        if not fields or FIELD.sub("", text) or not all(map(_is_number, fields.values())):
            problem = f"expected 'Frames: N' and 'Frame Time: seconds', found {lines[number].strip()[:40]!r}"
            raise FormatError(problem, place=f"line {number + 1}")
        found |= fields
        if len(found) == 2:
            count, step = float(found["frames"]), float(found["step"])
            if not (math.isfinite(count) and count == int(count) and SHORTEST_STEP <= step <= LONGEST_STEP):
                problem = f"the header is invalid: {count:g} frames of {step:g} s each"
                mend = f"Give a whole number of frames and {SHORTEST_STEP:g} to {LONGEST_STEP:g} seconds per frame"
                raise FormatError(problem, place=f"line {number + 1}", mend=mend)
            return Header(int(count), found["step"], number + 1)
    raise FormatError("the file ends before the frames", place=f"line {len(lines)}", mend=CUT_SHORT)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def read_frames(lines: list[str], header: Header, width: int, cut: bool) -> Frames:
    """Parses the frames of `width` values. Allocates for those that exist, whatever the header declares.

    If their number is not the header's, a warning has both. `cut`: the last line does not end. Raises FormatError.
    """
    rows = [(number, text) for number, text in enumerate(lines[header.end :], header.end + 1) if text.strip()]
    values = _table(rows, len(rows), width)
    frames = Frames(values) if values is not None else _read_loosely(rows, header.count, width)
    found = len(frames.values)
    if found == 0:
        raise FormatError("the file has no frames", mend="Export the motion, not only the rig")
    if found == header.count:
        return frames
    if cut and found < header.count and _ends_within_a_number(rows[-1][1]):
        problem = f"the last frame ends within a number, {rows[-1][1].split()[-1]!r}"
        raise FormatError(problem, place=f"line {rows[-1][0]}", mend=CUT_SHORT)
    warning = f"the header declares {header.count} frames, but the file has {found}; all {found} were read"
    return Frames(frames.values, frames.notes, (*frames.warnings, warning))


def _table(rows: list[Row], count: int, width: int, commas: bool = False) -> Floats | None:
    return read_table(as_bytes("\n".join(_numbers(text, commas) for _, text in rows)), count, width)


def _numbers(text: str, commas: bool) -> str:
    return text.replace(",", ".") if commas else text


def _read_loosely(rows: list[Row], count: int, width: int) -> Frames:
    """Reads frames with comments, decimal commas, line breaks in a frame, or other lines after the last frame."""
    rows = [row for row in rows if COMMENT.sub("", row[1]).strip()]
    body = [text for _, text in rows[: max(count, 0)] or rows]
    commas = any("," in text for text in body) and not any("." in text for text in body)
    values = _table(rows, len(rows), width, commas)
    if values is not None:
        return Frames(values, (COMMAS,) * commas)
    if any("," in text for _, text in rows):  # perhaps between the numbers
        values = _table([(number, text.replace(",", " ")) for number, text in rows], len(rows), width)
        if values is not None:
            return Frames(values)
    warnings: tuple[str, ...] = ()
    sizes = _sizes(rows, commas)
    if len(sizes) < len(rows):
        number, text = rows[len(sizes)]
        after_all = 0 < count <= len(sizes) or not any(NUMBER.match(text) for _, text in rows[len(sizes) :])
        if not sizes or not after_all:
            raise _bad_row(rows, len(sizes), width, commas)
        warnings = (f"left out what follows the last frame, from line {number}: {text.strip()[:40]!r}",)
        rows = rows[: len(sizes)]
    frames = count if sum(sizes) == count * width else _frames_of_lines(rows, sizes, count, width)
    values = _table([(0, " ".join(text for _, text in rows))], 1, frames * width, commas)
    if values is None:
        raise FormatError(f"expected {width} plain decimal numbers in every frame")
    return Frames(values.reshape(frames, width), (COMMAS,) * commas, warnings)


def _sizes(rows: list[Row], commas: bool) -> list[int]:
    """Returns the number of values in each row, up to the first row with a word that is not a finite number."""
    sizes = []
    for _, text in rows:
        words = _numbers(text, commas).split()
        if not all(map(is_finite, words)):
            break
        sizes.append(len(words))
    return sizes


def _bad_row(rows: list[Row], frame: int, width: int, commas: bool) -> FormatError:
    """Returns the error for a row with a word that is not a number."""
    number, text = rows[frame]
    words, place = text.split(), f"line {number}, frame {frame}"
    word = next(word for word in words if not is_finite(_numbers(word, commas)))
    if "," in word:
        mend = "Export the numbers with decimal points, separated by blanks, without thousands separators"
        return FormatError(f"it is unclear what the comma in {word[:20]!r} means", place=place, mend=mend)
    if frame == len(rows) - 1 and word == words[-1] and len(words) <= width:
        return FormatError(f"the last frame ends in {word[:20]!r}, which is not a number", place=place, mend=CUT_SHORT)
    return FormatError(f"{word[:20]!r} is not a finite number", place=place)


def _frames_of_lines(rows: list[Row], sizes: list[int], count: int, width: int) -> int:
    """Returns the number of frames, each of one line or several, given the number of values in each line.

    If there are as many lines as frames in the header, each line is meant to be a frame. Raises FormatError.
    """
    frame = found = start = 0
    for at, size in enumerate(sizes):
        if found and (found + size > width or len(rows) == count):
            break
        start = at if found == 0 else start
        found += size
        if found > width:
            break
        if found == width:
            frame, found = frame + 1, 0
    if found == 0:
        return frame
    problem = f"expected {width} values per frame, found {found}"
    mend = CUT_SHORT if found < width else f"Export the file again, with values for its {width} channels only"
    raise FormatError(problem, place=f"line {rows[start][0]}, frame {frame}", mend=mend)


def _ends_within_a_number(text: str) -> bool:
    """Returns whether all numbers of a row have as many decimals, but the last has fewer."""
    *others, last = (len(word.partition(".")[2]) for word in text.split())
    return len(others) > 1 and last < min(others) == max(others)
