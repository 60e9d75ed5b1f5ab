"""Compiles the programs of clients/cpp/tests, and evaluates splices with them."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.job.bank_builder import write_manifest
from motionsplice.precompute.job.written import write_tables
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import TABLES
from motionsplice.runtime.format.tables import TABLE_FOLDER
from motionsplice.runtime.requests import Requests

CLIENT = Path(__file__).parents[2] / "clients" / "cpp"
STRICT = ["-std=c++17", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wshadow"]
BARE = ["-fno-exceptions", "-fno-rtti"]  # as game engines are compiled
NOTHING = -2
NO_COMPILER = "" if shutil.which("g++") else "g++ is not installed"
needs_compiler = pytest.mark.skipif(bool(NO_COMPILER), reason=NO_COMPILER)


class Answer(NamedTuple):
    """What the program says about n characters with J joints.

    Attributes:
        roots: [n, 3] metres.
        rotations: [n, J, 4] xyzw.
        positions: [n, J, 3] metres.
        allocations: Number of allocations while the poses were evaluated.
    """

    roots: Floats
    rotations: Floats
    positions: Floats
    allocations: int


def compiled(source: str, to: Path, *options: str, compiler: str = "g++") -> Path:
    """Compiles a program, with warnings as errors."""
    command = [compiler, *STRICT, *options, str(CLIENT / "tests" / source), "-o", str(to)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return to


def run(program: Path, bank: Path, commands: str = "") -> list[str]:
    """Returns the lines that a program answers."""
    done = subprocess.run([program, bank], input=commands, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def command(requests: Requests, rate: float = 0.0) -> str:
    """Returns the command that evaluates requests; a rate above 0 gives the characters memories."""
    lines = [f"poses {len(requests)} {rate}"]
    for one in requests.records:
        hands = int(one["hands"]) - 1 if one["hands"] else NOTHING
        clips, kind = f"{one['locomotion']} {one['action']}", f"{one['method']} {one['posture']} {one['cycles']}"
        lines.append(f"{clips} {hands} {float(one['start'])!r} {kind} {float(one['time'])!r}")
    return "\n".join(lines) + "\n"


def answer(lines: Sequence[str], joints: int) -> Answer:
    """Reads the answer to one command."""
    numbers = np.array([line.split() for line in lines], np.float64)
    rotations, positions = 3 + 4 * joints, 3 + 7 * joints
    return Answer(
        numbers[:, :3],
        numbers[:, 3:rotations].reshape(-1, joints, 4),
        numbers[:, rotations:positions].reshape(-1, joints, 3),
        int(numbers[0, positions]),
    )


def written(bank: Bank, folder: Path) -> Path:
    """Writes a bank that exists in memory only; returns its folder."""
    (folder / TABLE_FOLDER).mkdir(parents=True)
    digests = write_tables(
        folder / TABLE_FOLDER, {name: (len(bank.tables[name]), [bank.tables[name]]) for name in TABLES}
    )
    write_manifest(folder, bank.skeleton, bank.roles, bank.mirror, bank.baseline, bank.clips, digests, bank.hands)
    return folder
