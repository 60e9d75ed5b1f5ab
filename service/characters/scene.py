"""The characters of one connection, as flat arrays: commands are the slow way in, frames the fast way out."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from runtime.arrays import MEMORY_COLUMNS
from runtime.in_step import action_phase, cycles_to, phase_at
from runtime.requests import METHODS, POSTURES, REQUEST, Memory, Requests, time_fault
from service.characters.commands import Command
from service.characters.playback import PLAYBACK, advance
from service.problems import LimitError, RequestError
from service.serving import Edition

Rows = NDArray[np.int64]

ROOM = 16  # characters that there is room for at first


class Scene:
    """Characters on an edition of the bank, one a row, in the order in which frames have them."""

    def __init__(self, edition: Edition, rate: float, most: int) -> None:
        self.edition = edition
        self._most = most
        self.share = Memory.begin(0, rate).share
        self._rows: dict[int, int] = {}
        self._records = np.zeros(ROOM, REQUEST)
        self._playback = np.zeros(ROOM, PLAYBACK)
        self._state = np.zeros((ROOM, MEMORY_COLUMNS))

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def ids(self) -> NDArray[np.uint32]:
        return np.ascontiguousarray(self._playback["id"][: len(self)])

    @property
    def records(self) -> NDArray[np.void]:
        """What the characters play now, [n] REQUEST."""
        return self._records[: len(self)]

    @staticmethod
    def together(scenes: Sequence[Scene]) -> tuple[NDArray[np.void], NDArray[np.float64]]:
        """The records and the state of all characters of some scenes; of one alone its own, not a copy."""
        if len(scenes) == 1:
            return scenes[0].records, scenes[0].state
        # NumPy joins rows of bytes a hundred times as fast as records, whose types it compares in Python
        rows = np.concatenate([scene.records.view(np.uint8).reshape(-1, REQUEST.itemsize) for scene in scenes])
        return rows.view(REQUEST)[:, 0], np.concatenate([scene.state for scene in scenes])

    @property
    def state(self) -> NDArray[np.float64]:
        """What the evaluator remembers of them, the state of a Memory."""
        return self._state[: len(self)]

    def copy(self) -> Self:
        """The same characters, on their own from now on."""
        twin = copy.copy(self)
        twin._rows = self._rows.copy()
        twin._records, twin._playback, twin._state = self._records.copy(), self._playback.copy(), self._state.copy()
        return twin

    def keep_time(self, rate: float) -> None:
        """For so many frames per second."""
        self.share = Memory.begin(0, rate).share

    def advance(self, seconds: float) -> list[int]:
        """Moves all on in time. Returns the ids of those that have come to the end of their locomotion and hold it."""
        count = len(self)
        if not advance(self._records[:count], self._playback[:count], seconds):
            return []
        time, playback = self._records["time"][:count], self._playback[:count]
        return self._end(np.flatnonzero(time > playback["end"]))

    def pass_frame(self, seconds: float) -> None:
        """As if a frame had been shown: what the evaluator remembers goes on too."""
        evaluator = self.edition.evaluator
        memory = Memory(self.state, self.share)
        evaluator.evaluate(Requests(self.records), evaluator.poses(len(self)), memory)
        self.advance(seconds)

    def _end(self, rows: Rows) -> list[int]:
        """Of characters that are past their end, some go back and some hold it."""
        loops, playback, records = rows[self._playback["loop"][rows]], self._playback, self._records
        length = playback["end"][loops] - playback["back"][loops]
        gone = np.ceil((records["time"][loops] - playback["end"][loops]) / length)
        records["time"][loops] -= gone * length
        records["cycles"][loops] += (gone * playback["cycles"][loops]).astype(np.int32)
        naive = loops[records["method"][loops] == METHODS["naive"]]
        self._begin_naive(naive, records["start"][naive] + (gone * length)[np.isin(loops, naive)])
        holds = rows[~playback["loop"][rows]]
        records["time"][holds] = playback["end"][holds]
        new = holds[~playback["held"][holds]]
        playback["held"][new] = True
        return [int(one) for one in playback["id"][new]]

    def do(self, command: Command) -> None:
        """Does a command. Raises MotionError, and may then have done it in part."""
        if command.do == "create":
            self._create(command.ids, **command.values)
            return
        missing = [one for one in command.ids if one not in self._rows]
        if missing:
            raise RequestError(f"id: there is no character {missing[0]}")
        rows = np.fromiter((self._rows[one] for one in command.ids), np.int64, len(command.ids))
        getattr(self, f"_{command.do}")(rows, **command.values)

    def _create(self, ids: Sequence[int], **values: Any) -> None:
        for one in ids:
            if one in self._rows:
                raise RequestError(f"id: there is a character {one} already")
        first, count = len(self), len(self) + len(ids)
        if count > self._most:
            raise LimitError(f"{count} characters are more than {self._most}", mend="Remove some first")
        if count > len(self._records):
            room = max(count, 2 * len(self._records))
            self._records, self._playback = _longer(self._records, room), _longer(self._playback, room)
            self._state = _longer(self._state, room)
        self._rows.update(zip(ids, range(first, count), strict=True))
        rows = np.arange(first, count)
        self._records[rows] = np.zeros((), REQUEST)
        self._playback[rows] = np.zeros((), PLAYBACK)
        self._playback["id"][rows] = ids
        self._playback["speed"][rows], self._playback["loop"][rows] = 1.0, True
        Memory(self._state, 0.0).forget(slice(first, count))
        self._play(rows, **values)

    def _play(self, rows: Rows, locomotion: str, time: float = 0.0, **values: Any) -> None:
        records, arrays = self._records, self.edition.evaluator.arrays
        acting = rows[records["method"][rows] != METHODS["none"]]
        old, action = records[acting], records["action"][acting]
        phase = action_phase(arrays, old["locomotion"], old["time"], action, old["cycles"])
        number = self.edition.bank.number(locomotion)
        records["locomotion"][rows] = number
        self._tie(rows)
        self._seek(rows, time)
        if "speed" in values:
            self._speed(rows, values["speed"])
        if "loop" in values:
            self._playback["loop"][rows] = values["loop"]
        alone = rows[records["method"][rows] == METHODS["none"]]
        records["action"][alone] = number
        records["cycles"][acting] = cycles_to(arrays, number, time, action, phase)  # it goes on, at the next step

    def _act(
        self, rows: Rows, action: str, start: float = 0.0, method: str = "splice", posture: str = "relative"
    ) -> None:
        records, arrays = self._records, self.edition.evaluator.arrays
        number = self.edition.bank.number(action)
        self._check_time("start", start, number)
        records["action"][rows], records["method"][rows] = number, METHODS[method]
        records["posture"][rows], records["start"][rows] = POSTURES[posture], 0.0
        now = records[rows]
        phase = phase_at(arrays, number, start)
        records["cycles"][rows] = cycles_to(arrays, now["locomotion"], now["time"], number, phase)
        if method == "naive":
            self._begin_naive(rows, start - now["time"])
        Memory(self._state, 0.0).forget(rows)  # type: ignore[arg-type]

    def _stop(self, rows: Rows) -> None:
        records = self._records
        records["action"][rows], records["method"][rows] = records["locomotion"][rows], METHODS["none"]
        records["start"][rows], records["cycles"][rows] = 0.0, 0

    def _seek(self, rows: Rows, time: float) -> None:
        for number in np.unique(self._records["locomotion"][rows]):
            self._check_time("time", time, number)
        self._records["time"][rows] = time
        self._playback["held"][rows] = False

    def _speed(self, rows: Rows, speed: float) -> None:
        self._playback["speed"][rows] = speed

    def _remove(self, rows: Rows) -> None:
        kept = np.delete(np.arange(len(self)), rows)
        for column in (self._records, self._playback, self._state):
            column[: len(kept)] = column[kept]
        self._rows = {int(one): row for row, one in enumerate(self._playback["id"][: len(kept)])}

    def missing(self, edition: Edition) -> list[str]:
        """Those of the clips played here that another edition has not."""
        clips, theirs = self.edition.bank.clips, {clip.name for clip in edition.bank.clips}
        return sorted({clips[number].name for number in self._played()} - theirs)

    def move(self, edition: Edition) -> None:
        """Plays on from another edition, which has all clips that are played here."""
        clips, numbers = self.edition.bank.clips, np.zeros(len(self.edition.bank.clips), np.int32)
        for number in self._played():
            numbers[number] = edition.bank.number(clips[number].name)
        self.edition, rows = edition, np.arange(len(self))
        for column in ("locomotion", "action"):
            self._records[column][rows] = numbers[self._records[column][rows]]
        self._tie(rows)
        time, end = self._records["time"][rows], self._playback["end"][rows]
        self._records["time"][rows] = np.minimum(time, end)
        naive = rows[self._records["method"][rows] == METHODS["naive"]]
        self._begin_naive(naive, self._records["start"][naive])

    def _played(self) -> list[int]:
        records = self._records[: len(self)]
        return [int(one) for one in np.union1d(records["locomotion"], records["action"])]

    def _tie(self, rows: Rows) -> None:
        """Looks up where locomotions end, and where they go on from there."""
        edition, numbers = self.edition, self._records["locomotion"][rows]
        for number in np.unique(numbers):
            of = rows[numbers == number]
            self._playback["end"][of] = edition.bank.clips[number].duration
            self._playback["back"][of] = edition.ways_back.times[number]
            self._playback["cycles"][of] = edition.ways_back.cycles[number]

    def _begin_naive(self, rows: Rows, start: NDArray[np.float64]) -> None:
        """Plain replacement counts seconds, and its clip repeats: brings `start` into the clip."""
        clips = self.edition.bank.clips
        ends = np.array([clips[number].duration for number in self._records["action"][rows]])
        self._records["start"][rows] = np.mod(start, ends) if len(rows) else start

    def _check_time(self, label: str, time: float, clip: int) -> None:
        if (fault := time_fault(label, time, self.edition.bank.clips[clip])) is not None:
            raise fault


def _longer(array: NDArray[Any], rows: int) -> NDArray[Any]:
    longer = np.zeros((rows, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer
