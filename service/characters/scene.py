"""The characters of one connection."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Self, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.aim import Aim, Look
from motionsplice.runtime.characters.state import (
    ACTION_BEGAN,
    ACTION_ENDED,
    BEGAN,
    ENDED,
    EVENT_NAMES,
    LOCOMOTION_ENDED,
)
from motionsplice.runtime.requests import Poses
from motionsplice.sending.receiver import Kind
from motionsplice.service.characters.commands import Command, ends_target
from motionsplice.service.problems import LimitError, RequestError
from motionsplice.service.serving import Edition

Target = TypeVar("Target", Look, Aim)
DEFAULT_EVENTS = ACTION_BEGAN | ACTION_ENDED | LOCOMOTION_ENDED


class Scene:
    """Characters that play an edition of the bank.

    Attributes:
        edition: The bank that is played.
        ids: [n] uint32, the client's number of each character, in the order of the frames' rows.
        events: Bits of the events that the client wants (`EVENT_NAMES`).
        characters: The states of the characters, in the same order.
        sent: The ids of the characters that are sent to each kind of receiver. Replaced, never changed.
    """

    def __init__(self, edition: Edition, rate: float, most: int, *, rebased: bool = False) -> None:
        self.edition = edition
        self.ids = np.zeros(0, np.uint32)
        self.events = DEFAULT_EVENTS
        self.characters = Characters(edition.stage, rate)
        self.sent: Mapping[Kind, tuple[int, ...]] = {}
        self._most = most
        self._rebased = rebased

    def __len__(self) -> int:
        return len(self.ids)

    def copy(self) -> Self:
        """Returns an independent copy."""
        twin = copy.copy(self)
        twin.characters = self.characters.copy()
        return twin

    def keep_time(self, rate: float) -> None:
        """Sets the number of frames per second."""
        self.characters = self.characters.at_rate(rate)

    def subscribe(self, names: Sequence[str]) -> None:
        """Sets which events `advance` reports."""
        self.events = sum(bit for bit, name in EVENT_NAMES.items() if name in names)

    def pass_frame(self) -> None:
        """Evaluates and advances by one frame, without reporting events."""
        self.characters.evaluate(self.edition.evaluator.poses(len(self)))
        self.characters.advance()

    def evaluate(self, out: Poses) -> None:
        self.characters.evaluate(out)

    def advance(self) -> Iterator[dict[str, Any]]:
        """Advances all characters by a frame. Yields events: name, ids and, for an action, its clip."""
        if self.characters.advance() & self.events:
            yield from self.happened()

    def happened(self) -> Iterator[dict[str, Any]]:
        """Yields the events of the last step that the client wants."""
        events, state = self.characters.events & self.events, self.characters.state
        happened = int(np.bitwise_or.reduce(events))
        for bit, name in EVENT_NAMES.items():
            rows = np.flatnonzero(events & bit) if happened & bit else ()
            column = {ACTION_BEGAN: BEGAN, ACTION_ENDED: ENDED}.get(bit)
            if column is None and len(rows):
                yield {"event": name, "ids": self.ids[rows].tolist()}
            elif column is not None:
                for number in np.unique(state[rows, column]):
                    ids = [int(self.ids[row]) for row in rows if state[row, column] == number]
                    bank = self.edition.bank
                    yield {"event": name, "ids": ids, "action": bank.whole(bank.numbered[int(number)].name)}

    def do(self, command: Command) -> None:
        """Does a command. Raises MotionError; the command may then be done in part."""
        if command.do == "create":
            self._create(command.ids, **command.values)
            return
        rows = self._rows(command.ids)
        if command.do == "remove":
            self.characters.remove(rows)
            self.ids = np.delete(self.ids, rows)
            self._send(command.ids, ())
            return
        if command.do == "send":
            self._send(command.ids, **command.values)
            return
        if command.do == "act":
            self.characters.act(rows, _action(**command.values))
        elif command.do == "look":
            self.characters.look(rows, _target(Look, command.values), **_blend(command.values))
        elif command.do == "aim":
            self.characters.aim(rows, _target(Aim, command.values), **_blend(command.values))
        else:
            getattr(self.characters, command.do)(rows, **command.values)

    def missing(self, edition: Edition) -> list[str]:
        """Returns the clips and hands that are played here and that another edition does not have."""
        return sorted(self.characters.missing_clips(edition.bank))

    def move(self, edition: Edition) -> None:
        """Continues with another edition, which must have all clips and hands that are played here."""
        self.characters = self.characters.moved(edition.stage)
        self.edition = edition

    def _create(self, ids: Sequence[int], locomotion: Any, **values: Any) -> None:
        if known := self.ids[np.isin(self.ids, ids)].tolist():
            raise RequestError(f"id: character {known[0]} already exists", mend="Choose another id")
        if len(self) + len(ids) > self._most:
            raise LimitError(f"{len(self) + len(ids)} characters are more than {self._most}", mend="Remove some first")
        begun = {key: values.pop(key) for key in ("time", "loop") if key in values}
        rows = self.characters.add(len(ids), locomotion, **begun)
        self.ids = np.concatenate([self.ids, np.array(ids, np.uint32)])
        if "speed" in values:
            self.characters.speed(rows, values["speed"])
        self.characters.place(rows, values.get("position", (0.0, 0.0, 0.0)), values.get("heading", 0.0))
        self.characters.in_place(rows, values.get("in_place", False))
        self.characters.lock_feet(rows, values.get("lock_feet", False))
        self.characters.rebase(rows, self._rebased)

    def _send(self, ids: Sequence[int], to: Sequence[Kind]) -> None:
        """Sends characters to these kinds of receivers, and to no others. VMC has one character: the last."""
        sent: dict[Kind, tuple[int, ...]] = {}
        moved = set(ids)
        for kind in get_args(Kind):
            others = tuple(one for one in self.sent.get(kind, ()) if one not in moved)
            if kind in to:
                others = tuple(ids) if kind == "vmc" else (*others, *ids)
            if others:
                sent[kind] = others
        self.sent = sent

    def _rows(self, ids: Sequence[int]) -> NDArray[np.int64]:
        if len(ids) == 1:  # most commands: sorting the ids of a crowd takes hundreds of times as long
            if not len(rows := np.flatnonzero(self.ids == ids[0])):
                raise RequestError(f"id: character {ids[0]} not found", mend="Create it first")
            return rows
        order = np.argsort(self.ids)
        at = np.searchsorted(self.ids, ids, sorter=order)
        rows = order[np.minimum(at, len(order) - 1)] if len(order) else np.zeros(len(ids), np.int64)
        missing = [one for one, row in zip(ids, rows, strict=True) if row >= len(self) or self.ids[row] != one]
        if missing:
            raise RequestError(f"id: character {missing[0]} not found", mend="Create it first")
        return rows


def _target(kind: type[Target], values: Mapping[str, Any]) -> Target | None:
    """Returns the target of a command `look` or `aim`; None if it is null."""
    return None if ends_target(values) else kind(**{key: values[key] for key in values.keys() - {"blend"}})


def _blend(values: Mapping[str, Any]) -> dict[str, float]:
    return {"blend": values["blend"]} if "blend" in values else {}


def _action(action: str, own_clock: bool | list[float] | None = None, **values: Any) -> Action:
    """Returns the action of a command `act`, whose JSON has lists in place of tuples."""
    clock = (own_clock[0], own_clock[1]) if isinstance(own_clock, list) else own_clock
    return Action(action, own_clock=clock, **values)
