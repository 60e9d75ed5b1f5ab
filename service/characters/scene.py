"""The characters of one connection: commands are the slow way in, frames the fast way out."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.state import (
    ACTION_BEGAN,
    ACTION_ENDED,
    BEGAN,
    ENDED,
    EVENT_NAMES,
    LOCOMOTION_ENDED,
)
from motionsplice.runtime.requests import Poses
from motionsplice.service.characters.commands import Command
from motionsplice.service.problems import LimitError, RequestError
from motionsplice.service.serving import Edition

FEW = 20_000  # characters times frames, which take some milliseconds
LONGEST_STEP = 0.1  # seconds
TOLD = ACTION_BEGAN | ACTION_ENDED | LOCOMOTION_ENDED  # unless a client wants others


class Scene:
    """Characters on an edition of the bank, in the order in which frames have them."""

    def __init__(self, edition: Edition, rate: float, most: int) -> None:
        self.edition = edition
        self.ids = np.zeros(0, np.uint32)
        self.told = TOLD
        self.characters = Characters(edition.stage, rate)
        self._most = most

    def __len__(self) -> int:
        return len(self.ids)

    def copy(self) -> Self:
        """The same characters, on their own from now on."""
        twin = copy.copy(self)
        twin.characters = self.characters.copy()
        return twin

    def keep_time(self, rate: float) -> None:
        """For so many frames per second."""
        self.characters = Characters(self.edition.stage, rate, self.characters.state)

    def tell(self, names: Sequence[str]) -> None:
        """Of which events to tell."""
        self.told = sum(bit for bit, name in EVENT_NAMES.items() if name in names)

    def pass_frame(self) -> None:
        """As if a frame had been shown, of which nothing is told."""
        self.characters.evaluate(self.edition.evaluator.poses(len(self)))
        self.characters.advance()

    def leave_out(self, frames: int) -> None:
        """As if frames had been shown that nobody sees: many in longer steps, so that who is late grows no later."""
        if frames * len(self) <= FEW:
            for _ in range(frames):
                self.pass_frame()
        else:
            step = math.ceil(LONGEST_STEP * self.characters.rate)
            for first in range(0, frames, step):
                self.characters.advance(min(step, frames - first))

    def evaluate(self, out: Poses) -> None:
        self.characters.evaluate(out)

    def advance(self) -> Iterator[dict[str, Any]]:
        """Moves all on by a frame, and says what happened: event, ids and, of an action, the clip."""
        happened = self.characters.advance() & self.told
        if happened:
            events, state = self.characters.events, self.characters.state
            for bit, name in EVENT_NAMES.items():
                rows = np.flatnonzero(events & bit) if happened & bit else ()
                column = {ACTION_BEGAN: BEGAN, ACTION_ENDED: ENDED}.get(bit)
                if column is None and len(rows):
                    yield {"event": name, "ids": self.ids[rows].tolist()}
                elif column is not None:
                    for number in np.unique(state[rows, column]):
                        about = [int(self.ids[row]) for row in rows if state[row, column] == number]
                        yield {"event": name, "ids": about, "action": self.edition.bank.clips[int(number)].name}

    def do(self, command: Command) -> None:
        """Does a command. Raises MotionError, and may then have done it in part."""
        if command.do == "create":
            self._create(command.ids, **command.values)
            return
        rows = self._rows(command.ids)
        if command.do == "remove":
            self.characters.remove(rows)
            self.ids = np.delete(self.ids, rows)
            return
        if command.do == "act":
            self.characters.act(rows, _action(**command.values))
        else:
            getattr(self.characters, command.do)(rows, **command.values)

    def missing(self, edition: Edition) -> list[str]:
        """Those of the clips and hands played here that another edition has not."""
        return sorted(self.characters.missing_clips(edition.bank))

    def move(self, edition: Edition) -> None:
        """Plays on from another edition, which has all clips and hands that are played here."""
        self.characters = self.characters.moved(edition.stage)
        self.edition = edition

    def _create(self, ids: Sequence[int], locomotion: Any, **values: Any) -> None:
        if known := self.ids[np.isin(self.ids, ids)].tolist():
            raise RequestError(f"id: there is a character {known[0]} already")
        if len(self) + len(ids) > self._most:
            raise LimitError(f"{len(self) + len(ids)} characters are more than {self._most}", mend="Remove some first")
        begun = {key: values.pop(key) for key in ("time", "loop") if key in values}
        rows = self.characters.add(len(ids), locomotion, **begun)
        self.ids = np.concatenate([self.ids, np.array(ids, np.uint32)])
        if "speed" in values:
            self.characters.speed(rows, values["speed"])
        self.characters.place(rows, values.get("position", (0.0, 0.0, 0.0)), values.get("heading", 0.0))
        self.characters.in_place(rows, values.get("in_place", False))

    def _rows(self, ids: Sequence[int]) -> NDArray[np.int64]:
        order = np.argsort(self.ids)
        at = np.searchsorted(self.ids, ids, sorter=order)
        rows = order[np.minimum(at, len(order) - 1)] if len(order) else np.zeros(len(ids), np.int64)
        missing = [one for one, row in zip(ids, rows, strict=True) if row >= len(self) or self.ids[row] != one]
        if missing:
            raise RequestError(f"id: there is no character {missing[0]}")
        return rows


def _action(action: str, own_clock: bool | list[float] = False, **values: Any) -> Action:
    """The record of a command `act`, whose JSON has lists for tuples."""
    clock = own_clock if isinstance(own_clock, bool) else (own_clock[0], own_clock[1])
    return Action(action, own_clock=clock, **values)
