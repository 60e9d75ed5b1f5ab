"""Commands of a WebSocket, parsed from untrusted text (docs/protocol.md, "Characters over a WebSocket")."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, get_args

import orjson

from motionsplice.motion.axes import Axes
from motionsplice.motion.errors import did_you_mean
from motionsplice.runtime.characters.action import ActionMethod
from motionsplice.runtime.characters.aim import FARTHEST, LARGEST_PITCH, LARGEST_YAW, AimPart
from motionsplice.runtime.characters.state import EVENT_NAMES, Curve, Mask, When
from motionsplice.runtime.requests import Posture
from motionsplice.sending.receiver import Kind
from motionsplice.service.parsing import loads
from motionsplice.service.problems import RequestError

LARGEST_ID = 2**32 - 1
FASTEST = 8.0  # times a clip's own speed
IDS = 10.0  # further characters of a command that count as another
PIECE, MOST_IDS = 8.0, 256  # commands, or characters of one command, that are done in a turn: 0.2 to 0.8 ms
WHOLE = frozenset({"set", "send"})  # commands that are not divided: they cost as much for many characters as for one

REF_TYPES = (int, float, str, type(None))  # compared with type(), which excludes bool

Check = Callable[[Any], bool]


@dataclass(frozen=True)
class Command:
    """One command: its name, the ids of its characters, and its other values by key."""

    do: str
    ids: tuple[int, ...]
    values: Mapping[str, Any]


def _number(least: float, most: float) -> Check:
    return lambda value: type(value) in (int, float) and math.isfinite(value) and least <= value <= most


def _one_of(*names: str) -> Check:
    return lambda value: isinstance(value, str) and value in names


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_mix(value: object) -> bool:
    return isinstance(value, dict) and all(_number(0.0, 1e9)(weight) for weight in value.values())


def _are(count: int, check: Check) -> Check:
    return lambda value: isinstance(value, list) and len(value) == count and all(check(one) for one in value)


def _names(kind: Any) -> tuple[Check, str]:
    return _one_of(*get_args(kind)), f"one of {', '.join(get_args(kind))}"


SECONDS, FAR = _number(0.0, 1e9), _number(-FARTHEST, FARTHEST)
TIME, SHARE = (SECONDS, "at least 0 seconds"), (_number(0.0, 1.0), "a number from 0 to 1")
FLAG: tuple[Check, str] = (lambda value: isinstance(value, bool)), "true or false"
FINITE, PLACE = _number(-math.inf, math.inf), f"a list of three numbers of at most {FARTHEST:,.0f}"
KEYS: Mapping[str, tuple[Check, str]] = {
    "locomotion": (lambda value: _is_text(value) or _is_mix(value), "a clip name, or a map of clip names to weights"),
    "weights": (_is_mix, "a map of clip names to weights"),
    "action": (_is_text, "a clip name"),
    "hands": (lambda value: value is None or _is_text(value), "the name of a hands clip, or null for none"),
    "blend": TIME,
    "blend_out": TIME,
    "curve": _names(Curve),
    "when": _names(When),
    "mask": _names(Mask),
    "weight": SHARE,
    "own_clock": (
        lambda value: isinstance(value, bool) or _are(2, SECONDS)(value),
        "true, false or two times of the action in seconds",
    ),
    "point": (lambda value: value is None or _are(3, FAR)(value), f"{PLACE}, or null for none"),
    "direction": (
        lambda value: value is None or (_are(3, FINITE)(value) and any(value)),
        "a list of three numbers that are not all 0, or null for none",
    ),
    "part": _names(AimPart),
    "spine": SHARE,
    "steady": SHARE,
    "max_yaw": (_number(0.0, LARGEST_YAW), f"radians from 0 to {LARGEST_YAW:.2f}"),
    "max_pitch": (_number(0.0, LARGEST_PITCH), f"radians from 0 to {LARGEST_PITCH:.2f}"),
    "position": (_are(3, FAR), PLACE),
    "heading": (FAR, f"radians, at most {FARTHEST:,.0f}"),
    "in_place": FLAG,
    "lock_feet": FLAG,
    "events": (
        lambda value: isinstance(value, list) and all(_one_of(*EVENT_NAMES.values())(one) for one in value),
        f"a list of {', '.join(EVENT_NAMES.values())}",
    ),
    "time": TIME,
    "start": TIME,
    "speed": (_number(0.0, FASTEST), f"a number from 0 to {FASTEST:g}"),
    "loop": FLAG,
    "method": _names(ActionMethod),
    "posture": _names(Posture),
    "to": (
        lambda value: isinstance(value, list) and all(_one_of(*get_args(Kind))(one) for one in value),
        f"a list of {', '.join(get_args(Kind))}",
    ),
    "rate": (_number(1.0, 1000.0), "a number of frames per second from 1 to 1000"),
    "ahead": (lambda value: type(value) is int and 1 <= value <= 1000, "a whole number of frames from 1 to 1000"),
}
NEEDED: Mapping[str, tuple[str, ...]] = {
    "create": ("locomotion",),
    "play": ("locomotion",),
    "act": ("action",),
    "stop": (),
    "wear": ("hands",),
    "look": (),
    "aim": (),
    "mix": ("weights",),
    "weight": ("weight",),
    "speed": ("speed",),
    "place": ("position",),
    "in_place": ("in_place",),
    "lock_feet": ("lock_feet",),
    "send": ("to",),
    "remove": (),
    "set": (),
}
TARGETED = ("look", "aim")
OPTIONAL: Mapping[str, tuple[str, ...]] = {
    "create": ("time", "loop", "speed", "position", "heading", "in_place", "lock_feet"),
    "play": ("time", "loop", "blend", "curve"),
    "act": (
        *("when", "start", "blend", "blend_out", "curve", "weight", "loop", "own_clock", "mask", "method", "posture"),
    ),
    "stop": ("blend", "curve"),
    "wear": ("blend", "curve", "weight"),
    "look": ("point", "direction", "blend", "weight", "spine", "steady", "max_yaw", "max_pitch"),
    "aim": ("point", "direction", "part", "blend", "weight", "steady", "max_yaw", "max_pitch"),
    "place": ("heading",),
    "set": ("rate", "ahead", "events"),
}


def cost(text: str) -> float:
    """Returns how many commands a message counts as, from its text alone: it is charged before it is parsed.

    A command is a map, and has fewer than ten commas unless it is for many characters.
    """
    return max(1.0, text.count("{"), text.count("["), text.count(",") / IDS, len(text) / 1024.0)


def in_pieces(commands: Iterable[Command]) -> Iterator[list[Command]]:
    """Yields commands in pieces that are done within about a millisecond. Long lists of characters are divided."""
    piece: list[Command] = []
    room = PIECE
    for command in commands:
        for part in _parts(command):
            if room <= 0.0:
                yield piece
                piece, room = [], PIECE
            piece.append(part)
            room -= 1.0 + len(part.ids) * PIECE / MOST_IDS
    if piece:
        yield piece


def _parts(command: Command) -> Iterable[Command]:
    if len(command.ids) <= MOST_IDS or command.do in WHOLE:
        return (command,)
    firsts = range(0, len(command.ids), MOST_IDS)
    return (replace(command, ids=command.ids[first : first + MOST_IDS]) for first in firsts)


def parse(text: str) -> list[Any]:
    """Returns the commands of a text message, unchecked. Raises RequestError."""
    try:
        document = loads(text)
    except orjson.JSONDecodeError as error:
        raise RequestError(f"the message is not JSON ({error})") from None
    listed = document if isinstance(document, list) else [document]
    if not listed:
        raise RequestError("the list of commands is empty")
    return listed


def ref_of(listed: list[Any]) -> int | float | str | None:
    """Returns the `ref` of a message's first command, which the reply repeats, or None if it is not valid."""
    ref = listed[0].get("ref") if isinstance(listed[0], dict) else None
    return ref if type(ref) in REF_TYPES else None


def checked(listed: list[Any], axes: Axes) -> Iterator[Command]:
    """Yields the commands of a message, with places in our axes. Raises RequestError about the first that is wrong.

    Args:
        listed: The commands, as `parse` returns them.
        axes: The axes of their positions and headings.
    """
    for number, fields in enumerate(listed):
        try:
            command = _command(fields)
            command = command if axes.ours else replace(command, values=_in_our_axes(command.values, axes))
        except RequestError as error:
            place = f"command {number}" if len(listed) > 1 else ""
            raise RequestError(error.problem, place=place, mend=error.mend) from None
        yield command


def _in_our_axes(values: Mapping[str, Any], axes: Axes) -> Mapping[str, Any]:
    converters: Mapping[str, Callable[[Any], Any]] = {
        "position": axes.metres,
        "point": lambda point: point and axes.metres(point),
        "direction": lambda direction: direction and axes.metres(direction),
        "heading": lambda heading: axes.turn * heading,
    }
    return {key: converters[key](value) if key in converters else value for key, value in values.items()}


def _command(fields: object) -> Command:
    if not isinstance(fields, dict):
        raise RequestError(f"expected a command, which is a map, found {fields!r:.40}")
    if type(ref := fields.get("ref")) not in REF_TYPES:
        raise RequestError(f"ref: expected a number or text, found {ref!r:.40}")
    do = fields.get("do")
    if not isinstance(do, str) or do not in NEEDED:
        raise RequestError(f"do: unknown command {do!r:.40}", mend=did_you_mean(str(do)[:40], NEEDED))
    needed, values = NEEDED[do], {}
    known = (*needed, *OPTIONAL.get(do, ()))
    for key, value in fields.items():
        if key in ("do", "id", "ref") and not (key == "id" and do == "set"):
            continue
        if key not in known:
            raise RequestError(f"{do} has no key {key[:40]!r}", mend=f"Its keys are {', '.join(known) or 'id only'}")
        check, expected = KEYS[key]
        if not check(value):
            raise RequestError(f"{key}: expected {expected}, found {value!r:.40}")
        values[key] = value
    for key in needed:
        if key not in values:
            raise RequestError(f"{key}: missing, but {do} requires it")
    if do in TARGETED and ("point" in values) == ("direction" in values):
        raise RequestError(f"{do} requires a point or a direction, and not both", mend="Give one of them; null ends it")
    if ends_target(values) and values.keys() - {"point", "direction", "blend"}:
        raise RequestError(f"{do}: null ends it, and may have no other key than blend")
    return Command(do, () if do == "set" else _ids(fields.get("id")), values)


def ends_target(values: Mapping[str, Any]) -> bool:
    """Whether the values of a command `look` or `aim` end it: its point or direction is null."""
    return None in (values.get("point", ""), values.get("direction", ""))


def _ids(value: object) -> tuple[int, ...]:
    ids = tuple(value) if isinstance(value, list) else (value,)
    if not ids or not all(type(one) is int and 0 <= one <= LARGEST_ID for one in ids):
        expected = f"a whole number from 0 to {LARGEST_ID}, or a list of them that is not empty"
        raise RequestError(f"id: expected {expected}, found {value!r:.40}")
    if len(set(ids)) != len(ids):
        raise RequestError("id: the list has a number twice", mend="List each character once")
    return ids
