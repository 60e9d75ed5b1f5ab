"""A shared library with the functions of sampler.h, called in this process."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.rounds import Work
from motionsplice.motion import quaternion
from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.kernels.arrays import SpliceArrays
from motionsplice.runtime.kernels.evaluate import action_frames
from motionsplice.runtime.requests import Poses, Requests
from motionsplice.runtime.simd.handle import handle_of

REQUEST = np.dtype(  # sampler_request
    [
        ("locomotion", np.int32),
        ("action", np.int32),
        ("time", np.float64),
        ("start", np.float64),
        ("action_time", np.float64),
    ],
    align=True,
)
UNIT = 1e-3  # by which the lengths of quaternions may differ from 1
ABI = "Compile it with -shared -fPIC, with the functions of bench/speed/sampler.h"


class Sampler:
    """A library that has opened the bank of an evaluator.

    Raises:
        SettingsError: It cannot be loaded, lacks a function, or does not open the bank.
    """

    def __init__(self, library: Path, evaluator: Evaluator) -> None:
        self._evaluator, self._name = evaluator, library.name
        try:
            loaded = ctypes.CDLL(str(library.resolve()))
            opening, self._call, self._close = (
                getattr(loaded, f"sampler_{name}") for name in ("open", "evaluate", "close")
            )
        except (OSError, AttributeError) as error:
            raise SettingsError(f"cannot be used: {error}", file=self._name, mend=ABI) from None
        opening.restype = ctypes.c_void_p
        self._sampler = ctypes.c_void_p(opening(str(evaluator.bank.path).encode()))
        if not self._sampler:
            raise SettingsError(f"does not open the bank {evaluator.bank.path}", file=self._name)

    def close(self) -> None:
        """Ends the use of the library."""
        self._close(self._sampler)

    def evaluation(self, sets: Sequence[Requests], poses: Poses) -> Work:
        """Work that evaluates one set of requests per round into `poses`. Raises SettingsError if one fails."""
        calls = [self._requests(requests) for requests in sets]
        *addresses, rotations, roots = (  # which keep the arrays
            array.ctypes.data_as(ctypes.c_void_p) for array in (*calls, poses.rotations, poses.root_positions)
        )
        count = len(sets[0])

        def evaluate(number: int) -> None:
            if self._call(self._sampler, addresses[number % len(addresses)], count, rotations, roots):
                raise SettingsError("failed to evaluate", file=self._name)

        return evaluate

    def difference(self, requests: Requests) -> float:
        """Returns the median angle, in radians, of its joints' rotations to those of the kernels.

        Raises:
            SettingsError: It does not write unit quaternions.
        """
        ours, theirs = (self._evaluator.poses(len(requests)) for _ in range(2))
        self._evaluator.evaluate(requests, ours)
        theirs.rotations[:] = 0.0
        self.evaluation([requests], theirs)(0)
        lengths = quaternion.length(theirs.rotations.astype(np.float64))
        if not (np.abs(lengths - 1.0) <= UNIT).all():
            raise SettingsError("does not write unit quaternions [count, joints, 4]", file=self._name)
        return float(np.median(quaternion.angle(ours.rotations, theirs.rotations)))

    def _requests(self, requests: Requests) -> NDArray[np.void]:
        bank, found, frames = self._evaluator.bank, np.zeros(len(requests), REQUEST), np.empty(len(requests))
        for name in ("locomotion", "action", "time", "start"):
            found[name] = requests.records[name]
        handle = handle_of(SpliceArrays(self._evaluator.arrays, self._evaluator.scratch))
        action_frames(handle, requests.records, frames)
        found["action_time"] = frames / np.array([clip.rate for clip in bank.numbered])[requests.action]
        return found
