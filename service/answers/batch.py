"""The body of POST /v1/poses: columns of numbers for many characters, parsed from untrusted bytes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Self, get_args

import msgpack
import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import did_you_mean
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.requests import METHODS, POSTURES, Method, Requests
from motionsplice.service.answers.body import json_map
from motionsplice.service.problems import LimitError, RequestError
from motionsplice.service.wire.parameters import POSTURES_OF_A_MOMENT

COLUMNS: Mapping[str, str] = {"locomotion": "<i4", "action": "<i4", "hands": "<i4", "time": "<f8", "start": "<f8"}
NAMES: Mapping[str, tuple[str, ...]] = {
    "method": get_args(Method),
    "posture": POSTURES_OF_A_MOMENT,
}
KEYS = ("clips", *COLUMNS, *NAMES)
NONE = -1
FEWER = "Send several batches"


@dataclass(frozen=True)
class Batch:
    """The splices of n characters.

    Attributes:
        clips: Names of clips and hands, to which the columns refer.
        columns: Arrays [n] by key, as in COLUMNS. Clips and hands are indices into `clips`; NONE stands for no action
            and for the clip's own hands.
        method: One method for all characters.
        posture: One posture for all characters.
    """

    clips: tuple[str, ...]
    columns: Mapping[str, NDArray[Any]]
    method: str
    posture: str

    @classmethod
    def from_msgpack(cls, body: bytes, most: int) -> Self:
        """Parses a map of blobs. Raises RequestError or LimitError.

        Nested containers are not unpacked, so that memory stays within a few times the body's size.
        """
        unpacker = msgpack.Unpacker(max_buffer_size=len(body) or 1, max_array_len=0, max_map_len=0)
        unpacker.feed(body)
        values: dict[str, Any] = {}
        try:
            for _ in range(unpacker.read_map_header()):
                key = _known(unpacker.unpack(), values)
                values[key] = _texts(unpacker, most) if key == "clips" else unpacker.unpack()
            if unpacker.tell() != len(body):
                raise RequestError("the body has bytes after the map")
        except (ValueError, TypeError, OverflowError, msgpack.UnpackException) as error:
            problem = f"the body is not a MessagePack map of names and blobs ({error})"
            raise RequestError(problem, mend="Send each array as one blob of little-endian numbers") from None
        columns = {}
        for key, kind in COLUMNS.items():
            if key in values:
                size = np.dtype(kind).itemsize
                if not isinstance(blob := values[key], bytes) or len(blob) % size:
                    raise RequestError(f"{key}: expected a blob of {size} bytes for each character")
                columns[key] = np.frombuffer(blob, kind)
        return cls._checked(values, columns, most)

    @classmethod
    def from_json(cls, body: bytes, most: int) -> Iterator[Self | None]:
        """Parses a map of lists in steps of less than half a millisecond. Raises RequestError or LimitError.

        Yields None after each step but the last, and then the batch.
        """
        values, columns = json_map(body), {}
        yield None
        for key in list(values):
            _known(key, {})
            if key in COLUMNS:
                columns[key] = _column(key, values[key], most)
                yield None
        yield cls._checked(values, columns, most)

    @classmethod
    def _checked(cls, values: Mapping[str, Any], columns: dict[str, NDArray[Any]], most: int) -> Self:
        for key in ("clips", "locomotion", "time"):
            if key not in values:
                raise RequestError(f"{key}: missing")
        clips, count = values["clips"], len(columns["locomotion"])
        if not isinstance(clips, list) or not all(isinstance(one, str) for one in clips):
            raise RequestError("clips: expected a list of names")
        if max(count, len(clips)) > most:
            raise LimitError(f"{count} characters of {len(clips)} clips are more than {most}", mend=FEWER)
        columns.setdefault("action", np.full(count, NONE, "<i4"))
        columns.setdefault("hands", np.full(count, NONE, "<i4"))
        columns.setdefault("start", np.zeros(count))
        for key, column in columns.items():
            if len(column) != count:
                problem = f"{key}: expected {count} numbers, as many as locomotion has, found {len(column)}"
                own, other = np.dtype(COLUMNS[key]).name, np.dtype(COLUMNS["locomotion"]).name
                raise RequestError(problem, mend=f"In MessagePack {key} is {own}, and locomotion {other}")
        for key, least in (("locomotion", 0), ("action", NONE), ("hands", NONE)):
            outside = (columns[key] < least) | (columns[key] >= len(clips))
            if outside.any():
                first = int(np.argmax(outside))
                raise RequestError(
                    f"{key}: character {first} has index {columns[key][first]}, but there are {len(clips)} clips"
                )
        as_clip, as_hands = _uses(len(clips), columns)
        if (both := as_clip & as_hands).any():
            name = clips[int(np.argmax(both))]
            raise RequestError(f"hands: {name!r:.40} is also used as a clip", mend="List it twice in clips")
        choices = {key: values.get(key, default) for key, default in (("method", "splice"), ("posture", "relative"))}
        for key, name in choices.items():
            if name not in NAMES[key]:
                raise RequestError(f"{key}: expected one of {', '.join(NAMES[key])}, found {name!r:.40}")
        return cls(tuple(clips), columns, choices["method"], choices["posture"])

    def requests(self, bank: Bank) -> Requests:
        """Returns the batch as the evaluator's requests. Raises UnknownClipError."""
        locomotion, action, hands = (self.columns[key] for key in ("locomotion", "action", "hands"))
        as_clip, as_hands = _uses(len(self.clips), self.columns)
        numbers, hand_clips = np.zeros(len(self.clips), np.int32), set(bank.hand_clips)
        for one, name in enumerate(self.clips):
            is_hands = as_hands[one] or (not as_clip[one] and name in hand_clips)
            numbers[one] = bank.hand_number(name) if is_hands else bank.number(name)
        has_action, requests = action != NONE, Requests.empty(len(locomotion))
        if len(locomotion):
            requests.locomotion[:] = numbers[locomotion]
            requests.action[:] = numbers[np.where(has_action, action, locomotion)]
            requests.hands[:] = np.where(hands == NONE, 0, 1 + numbers[hands])
        requests.time[:], requests.start[:] = self.columns["time"], self.columns["start"]
        requests.method[:] = np.where(has_action, METHODS[self.method], METHODS["none"])
        requests.posture[:] = POSTURES[self.posture]
        return requests


def _column(key: str, value: object, most: int) -> NDArray[Any]:
    """Returns a list of numbers as a column. Raises RequestError or LimitError."""
    kinds = {int, float} if COLUMNS[key] == "<f8" else {int}
    if isinstance(value, list) and len(value) > most:
        raise LimitError(f"{key}: {len(value)} numbers are more than {most}", mend=FEWER)
    if not isinstance(value, list) or not set(map(type, value)) <= kinds:
        whole = "" if float in kinds else "whole "
        raise RequestError(f"{key}: expected a list of {whole}numbers")
    try:
        return np.array(value, COLUMNS[key])
    except (ValueError, OverflowError):
        raise RequestError(f"{key}: a number is too large") from None


def _uses(count: int, columns: Mapping[str, NDArray[Any]]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Returns which of `count` names are used as clips, and which as hands, both [count]."""
    as_clip, as_hands = np.zeros(count + 1, bool), np.zeros(count + 1, bool)  # NONE is the last, which is dropped
    as_clip[columns["locomotion"]] = as_clip[columns["action"]] = as_hands[columns["hands"]] = True
    return as_clip[:-1], as_hands[:-1]


def _known(key: object, values: Mapping[str, Any]) -> str:
    if not isinstance(key, str) or key not in KEYS:
        raise RequestError(f"unknown key {key!r:.40}", mend=did_you_mean(str(key)[:40], KEYS))
    if key in values:
        raise RequestError(f"{key}: given twice", mend="Give it once")
    return key


def _texts(unpacker: Any, most: int) -> list[str]:
    count = unpacker.read_array_header()
    if count > most:
        raise LimitError(f"{count} clips are more than {most}", mend=FEWER)
    return [unpacker.unpack() for _ in range(count)]
