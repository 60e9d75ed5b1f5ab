"""Bodies of POST /v1/poses, in MessagePack and JSON: columns and names by the protocol, other values, and damage."""

from __future__ import annotations

import json
import re
import struct
from functools import cache
from pathlib import Path
from typing import Any

import msgpack
import numpy as np

from bench.hostile.damage import damage_bytes, damage_text
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.service.answers.batch import COLUMNS, KEYS, NAMES, Batch
from tests.hardening.fuzz.banks import CLIPS, small_bank
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw

MOST = 10_000  # characters, as by default
NUMBERS = (0, 1, -1, 2, 2**31 - 1, -(2**31), 2**31, 2**63, 1e9, 0.5, float("nan"), float("inf"), -0.0, 1e308)
LARGEST = 4 * 2**20  # bytes of a body, as by default
VALUES: tuple[Any, ...] = (None, True, "", "splice", "clip 0", b"", b"abc", [], [[]], {}, [1, "a"], 3, 2**64 - 1, "\0")
BULK = (b"\x90", b"\x80", b"\xc0", b"\x91", b"\xa0", b"\xc4\x00", b"\x81\xa1a", b"\xdd\xff\xff\xff\xff", b"\xd4\x01x")
TEXTS = ("[" * 2000, "[],", "{}", '{"a":' * 500, "1e400", "9" * 5000, '"\\ud800"', "nul", "\ufeff", "[[],[]]")


def _numbers(draw: Draw, count: int, key: str) -> list[Any]:
    numbers: list[Any] = [draw.random() / 40.0 if key in ("time", "start") else draw.randrange(CLIPS)] * count
    if key == "hands":
        numbers = ([draw.choice((-1, -1, CLIPS)) for _ in range(3)] * count)[:count]
    if draw.rarely(3) and numbers:
        numbers[draw.randrange(len(numbers))] = draw.choice((*NUMBERS, *VALUES)) if draw.rarely(2) else -1
    return numbers


def _document(draw: Draw) -> dict[str, Any]:
    """Returns a batch as a map of lists, texts and numbers."""
    count = draw.choice((3, 0, 1, 12, 100))
    document: dict[str, Any] = {"clips": [*(f"clip {number}" for number in range(CLIPS)), "hands"]}
    if draw.rarely(4):
        odd = ("clip 0~mirror", "hands", "", "walk", "clip 1", 3, None)
        document["clips"] = [draw.choice(odd) for _ in range(draw.randrange(8))]
    for key in COLUMNS:
        if key in ("locomotion", "time") or draw.randrange(2):
            document[key] = _numbers(draw, count if not draw.rarely(12) else draw.randrange(9), key)
    for key, names in NAMES.items():
        if draw.randrange(2):
            document[key] = draw.choice(names)
    if draw.rarely(4):
        document[draw.choice((*KEYS, "x", "", "Clips"))] = draw.choice(VALUES)
    if draw.rarely(12):
        del document[draw.choice(tuple(document))]
    return document


def _packed(draw: Draw, document: dict[str, Any]) -> bytes:
    """Returns a document in MessagePack, with its columns as blobs."""
    pairs: list[tuple[Any, Any]] = []
    for key, value in document.items():
        if key in COLUMNS and isinstance(value, list) and not draw.rarely(12):
            kind, numbers = COLUMNS[key], [one if type(one) in (int, float) else 0 for one in value]
            clipped = np.clip(np.array(numbers, np.float64), -(2.0**31), 2.0**31 - 1.0) if kind == "<i4" else numbers
            with np.errstate(invalid="ignore"):
                value = np.array(clipped).astype(kind).tobytes()
            value = value[: draw.randrange(len(value) + 1)] if draw.rarely(20) else value
        pairs.append((key if not draw.rarely(40) else draw.choice(VALUES[:7]), value))
    if draw.rarely(20):
        pairs.append(draw.choice(pairs) if pairs else ("x", 0))
    count = len(pairs) if not draw.rarely(20) else draw.choice((0, 1, len(pairs) + 1, 2**32 - 1))
    parts = [struct.pack(">BI", 0xDF, count)]
    return b"".join([*parts, *(msgpack.packb(one) for pair in pairs for one in pair)])


def make(draw: Draw) -> Files:
    """Returns a body under the name of its format."""
    form = draw.choice(("msgpack", "json"))
    document = _document(draw)
    if form == "msgpack":
        body, bulk = _packed(draw, document), draw.choice(BULK)
    else:
        body, bulk = json.dumps(document, default=str).encode(), draw.choice(TEXTS).encode("utf-8", "surrogatepass")
    if draw.rarely(6):
        body = (damage_text if form == "json" and draw.randrange(2) else damage_bytes)(body, body, draw)
    if draw.rarely(20):
        at = draw.randrange(len(body) + 1)
        body = body[:at] + bulk * draw.choice((1, 1, 100, 2000)) + body[at:]
    return {form: body[:LARGEST]}


@cache
def _evaluator() -> Evaluator:
    evaluator = Evaluator(small_bank())
    evaluator.warm()  # else the first hybrid would wait for its kernels, and be taken for one that hangs
    return evaluator


def enter(files: Files, folder: Path) -> None:
    """Parses the body, and evaluates what it asks for."""
    (item,) = files.items()
    form, body = item
    bank = small_bank()
    *_, batch = Batch.from_json(body, MOST) if form == "json" else (Batch.from_msgpack(body, MOST),)
    assert batch is not None
    requests, evaluator = batch.requests(bank), _evaluator()
    evaluator.evaluate(requests, evaluator.poses(len(requests)))


EARLY = re.compile("the body is not")
DOOR = Door(make, enter, EARLY)
