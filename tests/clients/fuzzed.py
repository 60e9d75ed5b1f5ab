"""Inputs of clients/cpp/tests/fuzz.cpp: `python -m tests.clients.fuzzed FOLDER` writes six sound ones to start from."""

from __future__ import annotations

import itertools
import struct
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import msgpack

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST, TABLES
from tests import random_bank
from tests.clients import cpp


def sections(folder: Path) -> list[bytes]:
    """Returns the files of a bank: the manifest's body, then the tables."""
    packed = msgpack.unpackb((folder / MANIFEST).read_bytes())["body"]
    digests = msgpack.unpackb(packed)["tables"]
    return [packed, *((folder / "tables" / f"{digests[name]}.npy").read_bytes() for name in TABLES)]


def joined(files: list[bytes]) -> bytes:
    """Returns files as one input."""
    return b"".join(struct.pack("<I", len(file)) + file for file in files)


def small_banks() -> Iterator[Bank]:
    """Yields six banks small enough to fuzz, in which hands drive joints."""
    kinds = enumerate(itertools.cycle(random_bank.CLOUDS))
    banks = (random_bank.random_bank(seed, 9, 3, 3, clouds, hybrids=True) for seed, clouds in kinds)
    return itertools.islice((bank for bank in banks if bank.layout.hands.columns), 6)


if __name__ == "__main__":
    to = Path(sys.argv[1])
    to.mkdir(parents=True)
    for number, bank in enumerate(small_banks()):
        with tempfile.TemporaryDirectory() as folder:
            (to / f"seed_{number}").write_bytes(joined(sections(cpp.written(bank, Path(folder) / "bank"))))
