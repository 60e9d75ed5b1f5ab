"""Characters: what a game does with splices from one second to the next.

Each is a row of numbers (`runtime.characters.state`), and one call advances or evaluates all of them. Commands fill the
part of a row that waits; the kernels begin what waits when its moment has come.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import clock_kernels
from motionsplice.runtime.characters import pose_kernels as character_kernels
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action, waiting_action
from motionsplice.runtime.characters.clip_references import clip_references, hands_references, invalid_rows, newest_mix
from motionsplice.runtime.characters.commands import BLEND, Locomotion, not_negative, shares_of, weight_in_range
from motionsplice.runtime.requests import (
    FLOAT64,
    Memory,
    Poses,
    check_array,
    known,
    time_fault,
)
from motionsplice.runtime.stage import Stage

States = NDArray[np.float64]
Rows = NDArray[np.int64] | NDArray[np.bool_] | Sequence[int] | slice | int


class Characters:
    """n characters, which are shown `rate` times a second.

    state: [n, COLUMNS] float64, a row for each, to be saved, copied and restored at will. The same commands at the same
    frames give the same bytes, whichever other characters there are. Clips are named by their number in the bank, so a
    state goes with the bank it was saved of. Raises SettingsError if the state or the rate is not that.

    rows: those that a command is for, in any way in which NumPy names some.
    """

    def __init__(self, stage: Stage, rate: float, state: States | None = None) -> None:
        self.stage = stage
        self.rate = rate
        self.state = np.zeros((0, col.COLUMNS)) if state is None else state
        self._room = self.state  # whose first rows the state is, or was
        check_array("characters", self.state, FLOAT64, (len(self.state), col.COLUMNS))
        if not 0.0 < rate < np.inf:
            raise SettingsError(f"{rate} is no number of frames per second")
        if len(strange := invalid_rows(self.state, len(stage.bank.clips), len(stage.bank.hand_clips))):
            problem = f"character {strange[0]} plays what this bank has not, or is no row of one"
            raise SettingsError(problem, mend="Is its state that of another bank?")
        self._share = Memory.begin(0, rate).share

    @classmethod
    def warm(cls, stage: Stage) -> None:
        """Compiles the kernels, or loads them compiled."""
        characters = cls(stage, 60.0)
        characters.add(1, stage.bank.clips[0].name)
        characters.advance()
        characters.evaluate(stage.evaluator.poses(1))

    def __len__(self) -> int:
        return len(self.state)

    def copy(self) -> Self:
        """The same characters, on their own from now on."""
        twin = copy.copy(self)
        twin.state = twin._room = self.state.copy()
        return twin

    def add(self, count: int, locomotion: Locomotion, **options: Any) -> NDArray[np.int64]:
        """Adds characters at the origin, facing Z, and returns their rows; options are those of `play`."""
        rows = np.arange(len(self), len(self) + count)
        before, self.state = self.state, self._longer(count)
        self.state[rows] = 0.0
        self.state[rows[:, None], [col.SPEED, col.COS]] = 1.0
        try:
            self.play(rows, locomotion, **{"blend": 0.0, **options})
        except Exception:
            self.state = before
            raise
        return rows

    def _longer(self, count: int) -> States:
        """The state with so many rows more. Room is doubled when it is used up, so that one by one costs no more."""
        needed = len(self) + count
        if needed > len(self._room) or self.state.base is not self._room:
            self._room = np.empty((needed + len(self), col.COLUMNS))
            self._room[: len(self)] = self.state
        return self._room[:needed]

    def remove(self, rows: Rows) -> None:
        """Removes characters; those after them move up."""
        self.state = np.delete(self.state, rows, axis=0)

    def play(
        self,
        rows: Rows,
        locomotion: Locomotion,
        *,
        time: float = 0.0,
        blend: float = BLEND,
        curve: col.Curve = "smooth",
        loop: bool = True,
    ) -> None:
        """Goes over to a locomotion, or to a mix of up to MOST_MIXED by weight, within `blend` seconds.

        It enters in step with what is played, at the first moment from `time` on that is; one without a gait, or after
        one, just there. While two groups are still being blended a third one waits, and a newer one takes its place.
        Raises UnknownClipError, TimeRangeError or SettingsError.
        """
        weights = shares_of(self.stage.bank, locomotion)
        for clip in weights:
            if (fault := time_fault("time", time, self.stage.bank.clips[clip])) is not None:
                raise fault
        part = np.zeros(col.HANDS - col.NEXT_COUNT)
        part[:5] = len(weights), time, not_negative("blend", blend), known(col.CURVES, "curve", curve), loop
        for number, (clip, weight) in enumerate(weights.items()):
            part[col.NEXT_CLIPS - col.NEXT_COUNT + number] = clip
            part[col.NEXT_WEIGHTS - col.NEXT_COUNT + number] = weight
        self.state[rows, col.NEXT_COUNT : col.HANDS] = part
        self._begin(rows)

    def mix(self, rows: Rows, weights: Mapping[str, float]) -> None:
        """Changes the weights of the newest mix, of whose clips those left out get none: each frame, if you like, for
        they are followed within about a tenth of a second. Raises UnknownClipError or SettingsError."""
        given = shares_of(self.stage.bank, weights)
        goals = []
        for row in self._numbers(rows):
            clips, at = newest_mix(self.state[row])
            if missing := given.keys() - set(clips):
                name = self.stage.bank.clips[min(missing)].name
                raise SettingsError(f"{name!r} is not one of the locomotions that are mixed", mend="Play them first")
            goals.append((row, at, [given.get(clip, 0.0) for clip in clips]))
        for row, at, weighed in goals:
            self.state[row, at] = weighed

    def act(self, rows: Rows, action: Action) -> None:
        """Begins an action over what is played, in place of one that waits.

        Its speed follows the locomotion's phase, but for where it has its own clock, after which it comes back into
        step. The event ACTION_ENDED reports when an action that does not loop has faded out. Raises UnknownClipError,
        TimeRangeError or SettingsError.
        """
        part = waiting_action(action, self.stage.bank, self.stage.limbs, self.rate)
        self._wait(rows, part, known(col.WHENS, "moment", action.when))

    def stop(self, rows: Rows, *, blend: float = BLEND, curve: col.Curve = "smooth") -> None:
        """Fades all actions out within `blend` seconds. Raises SettingsError."""
        part = np.zeros(col.ACTION_COLUMNS)
        part[col.KIND], part[col.MASK] = col.OWN, col.UPPER_BODY
        part[col.LASTING], part[col.CURVE] = not_negative("blend", blend), known(col.CURVES, "curve", curve)
        self._wait(rows, part, col.NOW)

    def wear(
        self,
        rows: Rows,
        hands: str | None,
        *,
        blend: float = BLEND,
        curve: col.Curve = "smooth",
        weight: float = 1.0,
    ) -> None:
        """Lays hands over whatever is played of the clips to which they are aligned, within `blend` seconds.

        They take the place of others; None lays all hands off. Where another clip is played, its own hands are shown.
        While some are still being faded into others a third waits, and newer ones take its place. Raises
        UnknownClipError or SettingsError.
        """
        part = np.zeros(col.HANDS_COLUMNS)
        part[col.CLIP] = col.BARE if hands is None else self.stage.bank.hand_number(hands)
        part[[col.WEIGHT, col.LAGGING, col.GOAL]] = weight_in_range(weight)
        part[col.LASTING], part[col.CURVE] = not_negative("blend", blend), known(col.CURVES, "curve", curve)
        self.state[rows, col.NEXT_HANDS : col.HANDS_WAIT] = part
        self.state[rows, col.HANDS_WAIT] = 1.0
        self._begin(rows)

    def speed(self, rows: Rows, speed: float) -> None:
        """How fast they play, as a part of the clips' own speed. Raises SettingsError."""
        self.state[rows, col.SPEED] = not_negative("speed", speed)

    def weight(self, rows: Rows, weight: float) -> None:
        """How much of the newest action is shown, followed within about a tenth of a second. Raises SettingsError."""
        weight_in_range(weight)
        for row in self._numbers(rows):
            s = self.state[row]
            if s[col.WHEN]:
                s[col.NEXT_ACTION + col.GOAL] = weight
            elif s[col.ACTIONS]:
                s[col.FIRST_ACTION + (int(s[col.ACTIONS]) - 1) * col.ACTION_COLUMNS + col.GOAL] = weight

    def place(self, rows: Rows, position: Sequence[float], heading: float = 0.0) -> None:
        """Puts them elsewhere: position [3], metres, of the ground under them, and heading, radians about Y from Z.

        Raises SettingsError.
        """
        if np.shape(position) != (3,) or not np.isfinite([*position, heading]).all():
            raise SettingsError("a place needs three numbers, and a heading one")
        self.state[rows, col.PLACE : col.PLACE + 3] = position
        self.state[rows, col.HEADING] = heading
        self.state[rows, col.SIN], self.state[rows, col.COS] = np.sin(0.5 * heading), np.cos(0.5 * heading)

    def in_place(self, rows: Rows, in_place: bool = True) -> None:
        """Shows them at the origin, facing Z, for a game that moves them by `deltas` itself."""
        self.state[rows, col.IN_PLACE] = in_place

    def advance(self, frames: int = 1) -> int:
        """Moves all on by a frame. Returns the bits of all events that happened; `events` are each character's.

        Several frames in one step are nearly those one by one: what would begin or end within them does at their end.
        """
        stage, state = self.stage, self.state.reshape(-1)
        return int(clock_kernels.advance(stage.evaluator.arrays, stage.ground, state, frames / self.rate))

    def evaluate(self, out: Poses) -> None:
        """Writes every character's pose into `out`, which has as many rows. Raises SettingsError."""
        stage = self.stage
        if out.flat.shape != (len(self), 4 * stage.bank.skeleton.joint_count):
            raise SettingsError(f"there are {len(self)} characters, and room for {len(out.flat)} poses")
        work = (stage.evaluator.arrays, stage.limbs, self.state.reshape(-1), self._share)
        room = (stage.evaluator.scratch, stage.mixing)
        character_kernels.evaluate_characters(*work, *room, out.root_positions, out.flat)

    def missing_clips(self, bank: Bank) -> set[str]:
        """The names of clips that are played, or wait to be, and of hands that are worn, which another bank has not."""
        clips = {self.stage.bank.clips[number].name for number in np.unique(clip_references(self.state)[1]).tolist()}
        worn = {self.stage.bank.hand_clips[number] for number in np.unique(hands_references(self.state)[1]).tolist()}
        return (clips - {clip.name for clip in bank.clips}) | (worn - set(bank.hand_clips))

    def moved(self, stage: Stage) -> Characters:
        """The same characters on another bank, which has all clips and hands of theirs, at the same frames."""
        at, played = clip_references(self.state)
        numbers = np.zeros(len(self.stage.bank.clips))
        for number in np.unique(played).tolist():
            numbers[number] = stage.bank.number(self.stage.bank.clips[number].name)
        state = self.state.copy()
        state[at] = numbers[played]
        at, worn = hands_references(self.state)
        state[at] = [stage.bank.hand_number(self.stage.bank.hand_clips[number]) for number in worn]
        clock_kernels.recompute_from_frames(stage.evaluator.arrays, stage.ground, state.reshape(-1))
        return Characters(stage, self.rate, state)

    @property
    def deltas(self) -> States:
        """What the last frame added to where they are [n, 4]: metres to the left, up and ahead, as seen from where they
        were, and radians about Y."""
        return self.state[:, col.DELTA : col.DELTA + 4]

    @property
    def events(self) -> NDArray[np.int64]:
        """What happened to each [n] in the last frame, bits of EVENT_NAMES."""
        return self.state[:, col.EVENTS].astype(np.int64)

    def _begin(self, rows: Rows) -> None:
        stage, state = self.stage, self.state.reshape(-1)
        clock_kernels.begin(stage.evaluator.arrays, stage.ground, state, self._numbers(rows))

    def _numbers(self, rows: Rows) -> NDArray[np.int64]:
        return np.atleast_1d(np.arange(len(self))[rows])

    def _wait(self, rows: Rows, part: States, when: int) -> None:
        self.state[rows, col.NEXT_ACTION : col.NEXT_ACTION + col.ACTION_COLUMNS] = part
        self.state[rows, col.WHEN] = when
        self._begin(rows)
