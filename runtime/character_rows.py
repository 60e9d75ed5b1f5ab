"""The rows of characters: kept, copied, joined, moved to another bank, and read."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import clip_references as references
from motionsplice.runtime.characters import clock_kernels
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.ranges import check_rows
from motionsplice.runtime.characters.slots import ORIGINS_APART
from motionsplice.runtime.requests import FLOAT64, Memory, check_array
from motionsplice.runtime.stage import Stage

States = NDArray[np.float64]
Rows = NDArray[np.int64] | NDArray[np.bool_] | Sequence[int] | slice | int
SLOWEST, FASTEST = 1e-3, 1e6  # frames per second


class CharacterRows:
    """n characters as rows of numbers, on a stage, at a fixed frame rate. `Characters` documents the attributes."""

    def __init__(self, stage: Stage, rate: float, state: States | None = None) -> None:
        self.stage = stage
        self.state = np.zeros((0, col.COLUMNS)) if state is None else state
        self._room = self.state  # the array whose first rows are the state
        check_array("characters", self.state, FLOAT64, (len(self.state), col.COLUMNS))
        self._keep_time(rate)
        check_rows(self.state, len(stage.bank.numbered), len(stage.bank.hand_clips))

    def _keep_time(self, rate: float) -> None:
        if not SLOWEST <= rate <= FASTEST:
            problem = f"the rate is {rate}, expected {SLOWEST:g} to {FASTEST:g} frames per second"
            raise SettingsError(problem)
        self.rate = rate
        self._share = Memory.begin(0, rate).share

    def __len__(self) -> int:
        return len(self.state)

    def copy(self) -> Self:
        """Returns independent copies of the characters on the same stage."""
        twin = copy.copy(self)
        twin.state = twin._room = self.state.copy()
        return twin

    def at_rate(self, rate: float) -> Self:
        """Returns the same characters, with the same state array, at another number of frames per second.

        Raises:
            SettingsError: `rate` is out of range.
        """
        twin = copy.copy(self)
        twin._keep_time(rate)
        return twin

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Returns the characters of all parts as one, so that one call advances or evaluates all.

        Args:
            parts: Characters on the same stage, at the same rate, at least one. Their states become slices of the
                result's, until rows are added to them or removed.
        """
        if len(parts) == 1:
            return parts[0]
        whole = copy.copy(parts[0])
        whole.state = whole._room = np.concatenate([part.state for part in parts])
        first = 0
        for part in parts:
            first, part.state = first + len(part), whole.state[first : first + len(part)]
        return whole

    def _longer(self, count: int) -> States:
        """Returns the state with `count` more rows. Storage doubles when it is full, so adding one by one is cheap."""
        needed = len(self) + count
        if needed > len(self._room) or self.state.base is not self._room:
            self._room = np.empty((needed + len(self), col.COLUMNS))
            self._room[: len(self)] = self.state
        return self._room[:needed]

    def remove(self, rows: Rows) -> None:
        """Removes characters; later rows move up."""
        self.state = np.delete(self.state, rows, axis=0)

    def missing_clips(self, bank: Bank) -> set[str]:
        """Returns the names of clips and hands, played or waiting, that another bank does not have."""
        return references.missing_names(self.state, self.stage.bank, bank)

    def moved(self, stage: Stage) -> Self:
        """Returns copies on another bank, at the same frames. Raises UnknownClipError if it lacks a clip or hands."""
        state = references.renumbered(self.state, self.stage.bank, stage.bank)
        clock_kernels.recompute_from_frames(stage._handle, state.reshape(-1))
        twin = copy.copy(self)
        twin.stage, twin.state, twin._room = stage, state, state
        return twin

    @property
    def deltas(self) -> States:
        """Root motion of the last frame [n, 4], relative to the previous place and heading: metres to the left, up and
        ahead, and radians about Y."""
        return self.state[:, col.DELTA : col.DELTA + 4]

    @property
    def origins(self) -> States:
        """What root positions of the poses are relative to [n, 3], metres: 0, or after `rebase` the multiples of 256
        that are nearest to the character's place."""
        nearest = ORIGINS_APART * np.floor(self.state[:, col.PLACE : col.PLACE + 3] / ORIGINS_APART + 0.5)
        used = (self.state[:, col.REBASED] > 0.0) & (self.state[:, col.IN_PLACE] == 0.0)
        return np.where(used[:, None], nearest, 0.0)

    @property
    def events(self) -> NDArray[np.int64]:
        """Events of the last frame [n], bits of EVENT_NAMES."""
        return self.state[:, col.EVENTS].astype(np.int64)

    def _numbers(self, rows: Rows) -> NDArray[np.int64]:
        return np.atleast_1d(np.arange(len(self))[rows])
