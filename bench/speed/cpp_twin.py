"""The evaluator of clients/cpp, compiled for this machine and called in this process."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.rounds import Work
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.requests import Poses, Requests

OPTIONS = ["-std=c++17", "-O3", "-march=native", "-fno-exceptions", "-fno-rtti", "-shared", "-fPIC"]
NOTHING = -2
SPLICE = np.dtype(  # motionsplice::Splice
    [
        ("locomotion", np.int32),
        ("action", np.int32),
        ("hands", np.int32),
        ("start", np.float64),
        ("method", np.uint8),
        ("posture", np.uint8),
        ("cycles", np.int64),
    ],
    align=True,
)


class CppTwin:
    """The evaluator in C++, over the same bank in memory of its own. `missing` says why there is none, or is empty."""

    missing = "" if shutil.which("g++") else "g++ is not installed"

    def __init__(self, bank: Bank) -> None:
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder) / "twin.so"
            subprocess.run(["g++", *OPTIONS, Path(__file__).with_suffix(".cpp"), "-o", library], check=True)
            self._library = ctypes.CDLL(str(library))
        self._library.open_bank.restype = ctypes.c_void_p
        self._library.evaluate.restype = ctypes.c_bool
        self._twin = ctypes.c_void_p(self._library.open_bank(str(bank.path).encode()))
        assert self._twin, f"{bank.path} cannot be opened in C++"

    def __del__(self) -> None:
        self._library.close_bank(self._twin)

    def evaluation(self, sets: Sequence[Requests], poses: Poses) -> Work:
        """Work that evaluates one set of requests per round into `poses`."""
        calls = [self._arguments(requests, poses) for requests in sets]
        return lambda number: self._evaluate(*calls[number % len(calls)])

    def _arguments(self, requests: Requests, poses: Poses) -> tuple[Any, ...]:
        splices = np.zeros(len(requests), SPLICE)
        for name in ("locomotion", "action", "start", "method", "posture", "cycles"):
            splices[name] = requests.records[name]
        splices["hands"] = np.where(requests.hands > 0, requests.hands.astype(np.int32) - 1, NOTHING)
        arrays = splices, requests.time.copy(), poses.rotations, poses.root_positions
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
        return *pointers[:2], len(requests), *pointers[2:], arrays  # which must live as long as their addresses

    def _evaluate(self, *arguments: Any) -> None:
        assert self._library.evaluate(self._twin, *arguments[:-1])
