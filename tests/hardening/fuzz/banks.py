"""A small bank, whose parts are changed, and what is evaluated of banks that open."""

from __future__ import annotations

import ast
import tempfile
from collections.abc import Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

import msgpack
import numpy as np

from motionsplice.motion.procedural.library import make
from motionsplice.motion.procedural.stances import Performer, standing_action
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.format.manifest import FORMAT, MANIFEST, VERSION, content_digest
from motionsplice.runtime.format.tables import TABLE_FOLDER
from motionsplice.runtime.requests import METHODS, POSTURES, Requests
from tests import random_bank
from tests.clients.cpp import written
from tests.conftest import built
from tests.conftest import written as written_clips

JOINTS, CLIPS, POINTS = 9, 4, 4
SHARES = np.linspace(0.0, 1.0, 3)  # of a clip, at which poses are evaluated
_parsed = lru_cache(ast.literal_eval)  # NumPy parses the headers of the same tables for each input
WAYS = (("splice", "relative"), ("splice", "absolute"), ("naive", "off"))
MOST_CLIPS = 8
PLAYED = {"walk": ("walk",), "run": ("run",), "wave": ("walk", "wave")}
PLAYED_SETTINGS = '[wave]\nkind = "action"\n[hail]\nkind = "action"\n'


@cache
def small_bank() -> Bank:
    """Returns a bank with hands, a stance and a hybrid, opened from a folder that stays until the process ends."""
    folder = tempfile.TemporaryDirectory()
    bank = random_bank.random_bank(4, JOINTS, CLIPS, POINTS, "torso", hybrids=True)
    opened = Bank.open(written(bank, Path(folder.name) / "bank"))
    object.__setattr__(opened, "held", folder)
    return opened


@cache
def played_bank() -> Bank:
    """Returns a bank of a body that walks, runs, waves and greets, likewise."""
    folder = tempfile.TemporaryDirectory()
    clips = {name: make(*of, seed=1, seconds=3.0) for name, of in PLAYED.items()}
    clips["hail"] = standing_action("hail", Performer(), seed=1)
    opened = built(written_clips(Path(folder.name), clips, PLAYED_SETTINGS), Path(folder.name) / "bank")
    object.__setattr__(opened, "held", folder)
    return opened


@cache
def small_tables() -> Mapping[str, bytes]:
    """Returns the files of the small bank's tables, by the table's name."""
    return {name: file.read_bytes() for name, file in small_bank().files.items()}


def small_body() -> dict[str, Any]:
    """Returns a new copy of the body of the small bank's manifest."""
    body: dict[str, Any] = msgpack.unpackb(_packed_body())
    return body


@cache
def _packed_body() -> bytes:
    body: bytes = msgpack.unpackb(small_bank().manifest.data)["body"]
    return body


def body_with(tables: Mapping[str, bytes]) -> bytes:
    """Returns the body of the small bank's manifest, packed, with the digests of other tables."""
    body = _packed_body()
    for name, data in tables.items():
        body = body.replace(small_bank().manifest.tables[name].encode(), content_digest(data).encode())
    return body


def manifest_of(body: bytes) -> bytes:
    """Returns a manifest with a sound digest of any body."""
    return msgpack.packb({"format": FORMAT, "version": VERSION, "digest": content_digest(body), "body": body})


def use_bank(folder: Path, manifest: bytes, tables: Mapping[str, bytes]) -> None:
    """Writes a bank, opens it without verification as the service does, evaluates it, and verifies it.

    `tables` are those that are not of the small bank. They get the names that the digests of their contents give, and
    are removed again.
    """
    _write_small_tables(folder)
    (folder / MANIFEST).write_bytes(manifest)
    contents = {_table_file(folder, data): data for data in tables.values()}
    others = {file: data for file, data in contents.items() if not file.exists()}
    for file, data in others.items():
        file.write_bytes(data)
    try:
        with patch.object(ast, "literal_eval", _parsed):
            bank = Bank.open(folder, verify=False)
        evaluated(bank)
        bank.verify()
    finally:
        for file in others:
            file.unlink()


@cache
def _write_small_tables(folder: Path) -> None:
    (folder / TABLE_FOLDER).mkdir()
    for data in small_tables().values():
        _table_file(folder, data).write_bytes(data)


def _table_file(folder: Path, data: bytes) -> Path:
    return folder / TABLE_FOLDER / f"{content_digest(data)}.npy"


def evaluated(bank: Bank) -> None:
    """Evaluates every pair of the first clips, by each method and posture, at times from begin to end."""
    evaluator, count = Evaluator(bank), min(len(bank.clips), MOST_CLIPS)
    one, other = (numbers.ravel() for numbers in np.indices((count, count)))
    stretched = {clip.name for clip in bank.clips if clip.stretches}
    with_hands = {entry.body: 1 + bank.hand_number(entry.name) for entry in bank.hands if entry.body not in stretched}
    laid = np.array([with_hands.get(clip.name, 0) for clip in bank.clips])
    durations = np.array([clip.duration for clip in bank.clips])
    ways = [(share, *way) for share in SHARES for way in WAYS]
    requests = Requests.empty(len(ways) * len(one))
    for number, (share, method, posture) in enumerate(ways):
        part = slice(number * len(one), (number + 1) * len(one))
        requests.locomotion[part], requests.action[part] = one, other
        requests.time[part], requests.start[part] = share * durations[one], share * durations[other]
        requests.hands[part] = laid[other]
        requests.method[part], requests.posture[part] = METHODS[method], POSTURES[posture]
    evaluator.evaluate(requests, evaluator.poses(len(requests)))
