"""The body of POST /v1/poses: columns of numbers about many characters, from bytes that may be anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_args

import msgpack
import numpy as np
import orjson
from numpy.typing import NDArray

from motionsplice.motion.errors import did_you_mean
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.requests import METHODS, POSTURES, Method, Posture, Requests
from motionsplice.service.problems import LimitError, RequestError

COLUMNS: Mapping[str, str] = {"locomotion": "<i4", "action": "<i4", "hands": "<i4", "time": "<f8", "start": "<f8"}
NAMES: Mapping[str, tuple[str, ...]] = {"method": get_args(Method), "posture": get_args(Posture)}
KEYS = ("clips", *COLUMNS, *NAMES)
NONE = -1


@dataclass(frozen=True)
class Batch:
    """What n characters play: clips, and hands, by index into `clips`, as columns [n]; action and hands -1 are none."""

    clips: tuple[str, ...]
    columns: Mapping[str, NDArray[Any]]
    method: str
    posture: str

    @classmethod
    def from_msgpack(cls, body: bytes, most: int) -> Batch:
        """Reads a map of blobs. Only what the map may hold is unpacked, so nothing grows beyond the body's size."""
        unpacker = msgpack.Unpacker(max_buffer_size=len(body) or 1, max_array_len=0, max_map_len=0)
        unpacker.feed(body)
        values: dict[str, Any] = {}
        try:
            for _ in range(unpacker.read_map_header()):
                key = _known(unpacker.unpack(), values)
                values[key] = _texts(unpacker, most) if key == "clips" else unpacker.unpack()
            if unpacker.tell() != len(body):
                raise RequestError("something follows the map")
        except (ValueError, TypeError, OverflowError, msgpack.UnpackException) as error:
            raise RequestError(f"the body is no MessagePack map of names and blobs ({error})") from None
        columns = {}
        for key, kind in COLUMNS.items():
            if key in values:
                size = np.dtype(kind).itemsize
                if not isinstance(blob := values[key], bytes) or len(blob) % size:
                    raise RequestError(f"{key}: it should be a blob of {size} bytes a character")
                columns[key] = np.frombuffer(blob, kind)
        return cls._checked(values, columns, most)

    @classmethod
    def from_json(cls, body: bytes, most: int) -> Batch:
        """Reads a map of lists."""
        try:
            values = orjson.loads(body)
        except orjson.JSONDecodeError as error:
            raise RequestError(f"the body is no JSON ({error})") from None
        if not isinstance(values, dict):
            raise RequestError("the body is no map")
        columns = {}
        for key in list(values):
            _known(key, {})
            if key in COLUMNS:
                kinds = (int, float) if COLUMNS[key] == "<f8" else (int,)
                if not isinstance(values[key], list) or not all(type(one) in kinds for one in values[key]):
                    whole = "" if float in kinds else "whole "
                    raise RequestError(f"{key}: it should be a list of {whole}numbers")
                try:
                    columns[key] = np.array(values[key], COLUMNS[key])
                except (ValueError, OverflowError):
                    raise RequestError(f"{key}: a number is too large") from None
        return cls._checked(values, columns, most)

    @classmethod
    def _checked(cls, values: Mapping[str, Any], columns: dict[str, NDArray[Any]], most: int) -> Batch:
        for key in ("clips", "locomotion", "time"):
            if key not in values:
                raise RequestError(f"{key}: it is missing")
        clips, count = values["clips"], len(columns["locomotion"])
        if not isinstance(clips, list) or not all(isinstance(one, str) for one in clips):
            raise RequestError("clips: it should be a list of names")
        if max(count, len(clips)) > most:
            raise LimitError(
                f"{count} characters of {len(clips)} clips are more than {most}", mend="Send several batches"
            )
        columns.setdefault("action", np.full(count, NONE, "<i4"))
        columns.setdefault("hands", np.full(count, NONE, "<i4"))
        columns.setdefault("start", np.zeros(count))
        for key, column in columns.items():
            if len(column) != count:
                raise RequestError(f"{key}: it has {len(column)} numbers for {count} characters")
        for key, least in (("locomotion", 0), ("action", NONE), ("hands", NONE)):
            outside = (columns[key] < least) | (columns[key] >= len(clips))
            if outside.any():
                first = int(np.argmax(outside))
                raise RequestError(f"{key}: {columns[key][first]} of character {first} is none of {len(clips)} clips")
        played, worn = _named(len(clips), columns)
        if (both := played & worn).any():
            name = clips[int(np.argmax(both))]
            raise RequestError(f"hands: {name!r:.40} is played as a clip too", mend="Name it twice in clips")
        named = {key: values.get(key, default) for key, default in (("method", "splice"), ("posture", "relative"))}
        for key, name in named.items():
            if name not in NAMES[key]:
                raise RequestError(f"{key}: it is {name!r:.40}, and should be one of {', '.join(NAMES[key])}")
        return cls(tuple(clips), columns, named["method"], named["posture"])

    def requests(self, bank: Bank) -> Requests:
        """The same for the evaluator. Raises UnknownClipError."""
        locomotion, action, hands = (self.columns[key] for key in ("locomotion", "action", "hands"))
        played, worn = _named(len(self.clips), self.columns)
        numbers, hand_clips = np.zeros(len(self.clips), np.int32), set(bank.hand_clips)
        for one, name in enumerate(self.clips):
            is_hands = worn[one] or (not played[one] and name in hand_clips)
            numbers[one] = bank.hand_number(name) if is_hands else bank.number(name)
        acts, requests = action != NONE, Requests.empty(len(locomotion))
        if len(locomotion):
            requests.locomotion[:] = numbers[locomotion]
            requests.action[:] = numbers[np.where(acts, action, locomotion)]
            requests.hands[:] = np.where(hands == NONE, 0, 1 + numbers[hands])
        requests.time[:], requests.start[:] = self.columns["time"], self.columns["start"]
        requests.method[:] = np.where(acts, METHODS[self.method], METHODS["none"])
        requests.posture[:] = POSTURES[self.posture]
        return requests


def _named(count: int, columns: Mapping[str, NDArray[Any]]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which of so many names are played, and which are worn [count]."""
    played, worn = np.zeros(count + 1, bool), np.zeros(count + 1, bool)  # the last takes NONE
    played[columns["locomotion"]] = played[columns["action"]] = worn[columns["hands"]] = True
    return played[:-1], worn[:-1]


def _known(key: object, values: Mapping[str, Any]) -> str:
    if not isinstance(key, str) or key not in KEYS:
        raise RequestError(f"there is no key {key!r:.40}", mend=did_you_mean(str(key)[:40], KEYS))
    if key in values:
        raise RequestError(f"{key}: it is given twice", mend="Give it once")
    return key


def _texts(unpacker: Any, most: int) -> list[str]:
    count = unpacker.read_array_header()
    if count > most:
        raise LimitError(f"{count} clips are more than {most}", mend="Send several batches")
    return [unpacker.unpack() for _ in range(count)]
