"""Reads Acclaim motions (AMC), whose skeleton is in an ASF file."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError, did_you_mean, listed
from motionsplice.motion.formats.asf_amc.skeleton import (
    CUT_SHORT,
    AcclaimSkeleton,
    about_axes,
    numbers,
    spelled,
    spellings,
)
from motionsplice.motion.formats.decimals import as_bytes, is_finite, read_table
from motionsplice.motion.formats.fold import Nodes, still
from motionsplice.motion.formats.parsed import Parsed
from motionsplice.motion.formats.text import COMMAS, text_of, with_points
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Integers

RATE = 120.0  # frames per second, unless the file says otherwise


def parse_motion(data: bytes, skeleton: AcclaimSkeleton) -> Parsed:
    """Parses an AMC file: its nodes and unit, those of the skeleton, and its frames per second.

    Bones without values in any frame stay at rest. Raises FormatError, which names the line or the frame and bone.
    """
    lines = text_of(data, CUT_SHORT).splitlines()
    spelling = spellings([name for name, bone in skeleton.bones.items() if bone.dof])
    rows, labels, header = _take_even_frames(lines, spelling)
    degrees, rate, seen, number = True, RATE, 0, 0  # seen: bones in the current frame
    for number, text in enumerate(lines[:header], 1):
        word, *values = text.split(None, 1) or ["#"]
        key = spelled(word, spelling)
        if key in rows and values and len(rows[key]) == len(labels) - 1:
            rows[key].append(values[0])
            seen += 1
        elif key.isdecimal() and not values:
            _check_complete(rows, seen, len(labels) - 1, number)
            labels.append(key)
            seen = 0
        elif key.startswith(":"):
            degrees = degrees and key.upper() != ":RADIANS"
            rate = numbers(values, 1, number)[0] if key.upper() == ":SAMPLES-PER-SECOND" else rate
        elif key in rows:
            problem = f"expected one line with values for bone {key!r} in each frame"
            raise FormatError(problem, place=f"line {number}, frame {len(labels) - 1}")
        elif not key.startswith("#"):
            problem = f"the skeleton has no moving bone {key!r}"
            raise FormatError(problem, place=f"line {number}", mend=did_you_mean(key, spelling.values()))
    if header == len(lines):
        _check_complete(rows, seen, len(labels) - 1, number)
    if not rows.get("root"):
        raise FormatError("the file has no frames", mend=CUT_SHORT)
    if not 0.5 <= rate <= 1e4:
        problem = f"the rate is invalid: {rate:g} frames per second"
        raise FormatError(problem, mend="Set :SAMPLES-PER-SECOND to 0.5 to 10000")
    order, notes, warnings = _order(labels)
    notes += (COMMAS,) * any("," in texts[0] for texts in rows.values())
    resting = [name for name in dict.fromkeys(spelling.values()) if name not in rows]
    if resting:
        notes += (f"the motion has no values for these bones, which stay at rest: {listed(resting)}",)
    values_of = {name: _values(name, texts, len(skeleton.bones[name].dof))[order] for name, texts in rows.items()}
    nodes = _nodes(skeleton, values_of, degrees, len(data))
    return Parsed(nodes, rate, skeleton.unit, notes=notes, warnings=warnings)


def _take_even_frames(lines: list[str], spelling: Mapping[str, str]) -> tuple[dict[str, list[str]], list[str], int]:
    """Takes the frames if all list the same bones in the same order, as in nearly all files.

    It does so in a third of the time of parsing line by line. Returns the bones' values, the frames' numbers, and the
    count of lines that are still to be parsed, which are those of the header. For other files these are all lines,
    and there are no values and numbers, only the bones that occur.
    """
    starts = (number for number, text in enumerate(lines) if text.strip().isdecimal())
    first, second = next(starts, len(lines)), next(starts, len(lines))
    frame, period = lines[first + 1 : second], second - first
    words = [text.split(None, 1)[0] if text.strip() else "" for text in frame]
    keys = [spelled(word, spelling) for word in words]
    rows: dict[str, list[str]] = {}
    for place, (word, key) in enumerate(zip(words, keys, strict=True), 1):
        start, column = word + " ", lines[first + place :: period]
        if all(text.startswith(start) for text in column):
            rows[key] = [text[len(start) :] for text in column]
    numbered = [text.strip() for text in lines[first :: period or 1]]
    even = len(lines) - first == len(numbered) * period and all(map(str.isdecimal, numbered))
    if even and len(rows) == len(words) and set(rows) <= set(spelling.values()):
        return rows, numbered, first
    occurring = {spelled(text.split(None, 1)[0], spelling) for text in lines if text.strip()}
    return {name: [] for name in spelling.values() if name in occurring}, [], len(lines)


def _order(labels: list[str]) -> tuple[Integers, tuple[str, ...], tuple[str, ...]]:
    """Returns the order of the frames by number, or that of the file if a number comes twice; notes and warnings."""
    numbered = np.array([float(label) for label in labels])
    order = np.argsort(numbered, kind="stable")
    with np.errstate(invalid="ignore"):  # a number may be too large for a float
        steps = np.diff(numbered[order])
    if not np.all(steps > 0.0):
        return np.arange(len(labels)), (), ()
    notes = ("its frames were sorted by their numbers",) if np.any(order[1:] < order[:-1]) else ()
    if len(steps) == 0 or steps.min() == steps.max():
        return order, notes, ()
    before = numbered[order][int(np.argmax(steps))]
    return order, notes, (f"frames are missing: the numbers of the frames jump after frame {before:.0f}",)


def _check_complete(rows: dict[str, list[str]], seen: int, frame: int, line: int) -> None:
    if frame >= 0 and seen < len(rows):
        missing = next(name for name, texts in rows.items() if len(texts) <= frame)
        raise FormatError(f"frame {frame} has no values for bone {missing!r}", place=f"line {line}", mend=CUT_SHORT)


def _values(name: str, texts: list[str], width: int) -> Floats:
    """Parses one bone's values [F, width]."""
    values = read_table(as_bytes(with_points("\n".join(texts))), len(texts), width)
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
        if turns and name in values:
            order = "".join(axis for _, axis in turns)
            own = about_axes(order, values[name][:, [column for column, _ in turns]], degrees)
            axes = skeleton.axes[name]
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
