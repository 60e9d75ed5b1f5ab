"""Commands of a WebSocket, from text that may be anything (docs/protocol.md, "Characters over a WebSocket")."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, get_args

import orjson

from motionsplice.motion.errors import did_you_mean
from motionsplice.runtime.characters.state import EVENT_NAMES, Curve, Mask, When
from motionsplice.runtime.requests import Posture
from motionsplice.service.problems import RequestError

LARGEST_ID = 2**32 - 1
FASTEST = 8.0  # times a clip's own speed

Check = Callable[[Any], bool]


@dataclass(frozen=True)
class Command:
    """What is to be done, to which characters, and how."""

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


TIMES, FAR = _number(0.0, 1e9), _number(-1e9, 1e9)
KEYS: Mapping[str, tuple[Check, str]] = {
    "locomotion": (lambda value: _is_text(value) or _is_mix(value), "a clip's name, or a map of names to weights"),
    "weights": (_is_mix, "a map of names to weights"),
    "action": (_is_text, "a clip's name"),
    "hands": (lambda value: value is None or _is_text(value), "the name of hands, or null for the clips' own"),
    "blend": (TIMES, "seconds, at least 0"),
    "blend_out": (TIMES, "seconds, at least 0"),
    "curve": _names(Curve),
    "when": _names(When),
    "mask": _names(Mask),
    "weight": (_number(0.0, 1.0), "a number from 0 to 1"),
    "own_clock": (
        lambda value: isinstance(value, bool) or _are(2, TIMES)(value),
        "true, false or two times of the action, seconds",
    ),
    "position": (_are(3, FAR), "three numbers"),
    "heading": (FAR, "radians"),
    "in_place": (lambda value: isinstance(value, bool), "true or false"),
    "events": (
        lambda value: isinstance(value, list) and all(_one_of(*EVENT_NAMES.values())(one) for one in value),
        f"a list of {', '.join(EVENT_NAMES.values())}",
    ),
    "time": (TIMES, "seconds, at least 0"),
    "start": (TIMES, "seconds, at least 0"),
    "speed": (_number(0.0, FASTEST), f"a number from 0 to {FASTEST:g}"),
    "loop": (lambda value: isinstance(value, bool), "true or false"),
    "method": (_one_of("splice", "naive"), "one of splice, naive"),
    "posture": _names(Posture),
    "rate": (_number(1.0, 1000.0), "frames per second, at least 1"),
    "ahead": (lambda value: type(value) is int and 1 <= value <= 1000, "frames, at least 1"),
}
NEEDED: Mapping[str, tuple[str, ...]] = {
    "create": ("locomotion",),
    "play": ("locomotion",),
    "act": ("action",),
    "stop": (),
    "wear": ("hands",),
    "mix": ("weights",),
    "weight": ("weight",),
    "speed": ("speed",),
    "place": ("position",),
    "in_place": ("in_place",),
    "remove": (),
    "set": (),
}
TAKEN: Mapping[str, tuple[str, ...]] = {
    "create": ("time", "loop", "speed", "position", "heading", "in_place"),
    "play": ("time", "loop", "blend", "curve"),
    "act": (
        *("when", "start", "blend", "blend_out", "curve", "weight", "loop", "own_clock", "mask", "method", "posture"),
    ),
    "stop": ("blend", "curve"),
    "wear": ("blend", "curve", "weight"),
    "place": ("heading",),
    "set": ("rate", "ahead", "events"),
}


def parse(text: str) -> list[Any]:
    """The commands of a text message, unchecked. Raises RequestError."""
    try:
        told = orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise RequestError(f"the message is no JSON ({error})") from None
    listed = told if isinstance(told, list) else [told]
    if not listed:
        raise RequestError("there is no command in the list")
    return listed


def ref_of(listed: list[Any]) -> int | str | None:
    """What the first command wants its answer to repeat, if that can be repeated."""
    ref = listed[0].get("ref") if isinstance(listed[0], dict) else None
    return ref if type(ref) in (int, str) else None


def checked(listed: list[Any]) -> list[Command]:
    """The commands of a message. Raises RequestError, saying which is wrong and why."""
    commands = []
    for number, one in enumerate(listed):
        try:
            commands.append(_command(one))
        except RequestError as error:
            place = f"command {number}" if len(listed) > 1 else ""
            raise RequestError(error.problem, place=place, mend=error.mend) from None
    return commands


def _command(told: object) -> Command:
    if not isinstance(told, dict):
        raise RequestError("a command is a map")
    do = told.get("do")
    if not isinstance(do, str) or do not in NEEDED:
        raise RequestError(f"do: there is no command {do!r:.40}", mend=did_you_mean(str(do)[:40], NEEDED))
    needed, values = NEEDED[do], {}
    known = (*needed, *TAKEN.get(do, ()))
    for key, value in told.items():
        if key in ("do", "id", "ref") and not (key == "id" and do == "set"):
            continue
        if key not in known:
            raise RequestError(f"{do} takes no {key[:40]!r}", mend=f"It takes {', '.join(known) or 'only an id'}")
        check, wanted = KEYS[key]
        if not check(value):
            raise RequestError(f"{key}: it is {value!r:.40}, and should be {wanted}")
        values[key] = value
    for key in needed:
        if key not in values:
            raise RequestError(f"{key}: {do} needs it")
    return Command(do, () if do == "set" else _ids(told.get("id")), values)


def _ids(told: object) -> tuple[int, ...]:
    ids = tuple(told) if isinstance(told, list) else (told,)
    if not ids or not all(type(one) is int and 0 <= one <= LARGEST_ID for one in ids):
        raise RequestError(f"id: it should be a whole number from 0 to {LARGEST_ID}, or a list of such")
    if len(set(ids)) != len(ids):
        raise RequestError("id: a number is in the list twice")
    return ids
