"""Characters: locomotions, actions and hands played over time, with transitions, root motion and events.

Each character is a row of numbers (`runtime.characters.state`), and one call advances or evaluates all rows. A command
writes what is to begin into the waiting part of a row; kernels begin it when its moment has come.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.character_rows import CharacterRows, Rows, States
from motionsplice.runtime.characters import clip_references as references
from motionsplice.runtime.characters import clock_kernels
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action, running_rows, waiting_action, waiting_stop
from motionsplice.runtime.characters.aim import AIM_PARTS, FARTHEST, Aim, Look, give_target
from motionsplice.runtime.characters.commands import (
    BLEND,
    Locomotion,
    change_mix,
    fraction,
    lockable,
    not_negative,
    waiting_group,
    waiting_hands,
)
from motionsplice.runtime.requests import Poses, known
from motionsplice.runtime.stage import Stage

MOST_FRAMES = 10**12  # in one step


class Characters(CharacterRows):
    """n characters that play locomotions, actions and hands of a bank, at a fixed frame rate.

    Commands take `rows`: the characters they are for, as any NumPy index. A command that raises changes nothing. All
    commands raise UnknownClipError for unknown names, SettingsError for invalid settings, and IndexError for rows that
    do not exist.

    Args:
        stage: The bank, ready for characters.
        rate: Frames per second: how often `advance` and `evaluate` are called.
        state: Rows to start from; none if omitted.

    Attributes:
        stage: The stage.
        rate: Frames per second.
        state: [n, COLUMNS] float64, one row for each character; may be saved, copied and restored. The same commands
            at the same frames give the same bytes, whatever other characters there are. Rows refer to clips by number,
            so they belong to the bank they were made with. Whatever is written here, kernels stay within their tables.

    Raises:
        SettingsError: `rate` lies outside 0.001 to a million, `state` has another type or shape, or a row of it holds
            what no command leads to, or does not fit the bank.

    Example:
        ```python
        from motionsplice import Action, Bank, Characters, Evaluator, Stage

        characters = Characters(Stage(Evaluator(Bank.open("demo/bank"))), rate=60.0)
        hero, *_ = characters.add(2, "walk")
        characters.act(hero, Action("wave", when="left_foot", loop=False))
        poses = characters.stage.evaluator.poses(len(characters))
        for frame in range(120):
            characters.evaluate(poses)
            characters.advance()
        ```
    """

    @classmethod
    def warm(cls, stage: Stage) -> None:
        """Compiles the kernels or loads them from the cache, so that later calls do not wait."""
        characters = cls(stage, 60.0)
        characters.add(1, stage.bank.clips[0].name)
        characters.advance()
        characters.evaluate(stage.evaluator.poses(1))
        characters.moved(stage)

    def add(self, count: int, locomotion: Locomotion, *, time: float = 0.0, loop: bool = True) -> NDArray[np.int64]:
        """Adds `count` characters at the origin, facing Z, and returns their rows [count].

        Args:
            count: How many to add.
            locomotion: What they play, as in `play`.
            time: Seconds into the clips at which they start.
            loop: Whether to go on at the end of a clip, instead of holding its last frame.
        """
        if count < 0:
            raise SettingsError(f"cannot add {count} characters", mend="Add 0 or more")
        rows = np.arange(len(self), len(self) + count)
        before, self.state = self.state, self._longer(count)
        self.state[rows] = 0.0
        self.state[rows[:, None], [col.SPEED, col.COS]] = 1.0
        try:
            self.play(rows, locomotion, time=time, blend=0.0, loop=loop)
        except Exception:
            self.state = before
            raise
        return rows

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
        """Blends over to a locomotion, or to a group of locomotions that are mixed by weight.

        The new locomotion enters in step with the current one. If either has no gait, it enters exactly at `time`.
        While two groups are still being blended, a third waits; a newer one replaces it.

        Args:
            rows: The characters.
            locomotion: Name of a clip, or weights of up to 4 clips by name; only their ratios matter.
            time: Seconds into the clips: the earliest frame to enter at.
            blend: Seconds to blend.
            curve: Shape of the blend: `linear`, `smooth`, `ease_in` or `ease_out`.
            loop: Whether to go on at the end of a clip, instead of holding its last frame.

        Raises:
            TimeRangeError: `time` is NaN or outside a clip.
        """
        count, group = waiting_group(self.stage.bank, locomotion, time, blend, curve, loop)
        self.state[rows, col.NEXT_COUNT], self.state[rows, col.NEXT_TIME : col.FIRST_HANDS] = count, group
        self._begin(rows)

    def mix(self, rows: Rows, weights: Mapping[str, float]) -> None:
        """Changes the weights of the newest group. Characters follow within about a tenth of a second.

        It may be called in each frame. Clips of the group that are left out get weight 0; clips outside it are refused.

        Args:
            rows: The characters.
            weights: Weights by name of clip; only their ratios matter.
        """
        change_mix(self.stage.bank, self.state, self._numbers(rows), weights)

    def act(self, rows: Rows, action: Action) -> None:
        """Begins an action over the locomotion. It replaces an action that is still waiting.

        The action's speed follows the locomotion's phase, except while it plays by its own clock; afterwards it returns
        into step. The event ACTION_ENDED reports that an action without a loop has faded out.

        Raises:
            TimeRangeError: `action.start` is NaN or outside the clip.
        """
        slot = waiting_action(action, self.stage.bank, self.stage.arrays.limbs, self.rate)
        self._wait(rows, slot, known(col.WHENS, "moment", action.when))

    def stop(self, rows: Rows, *, blend: float = BLEND, curve: col.Curve = "smooth") -> None:
        """Fades out all actions within `blend` seconds."""
        self._wait(rows, waiting_stop(blend, curve), col.NOW)

    def wear(
        self, rows: Rows, hands: str | None, *, blend: float = BLEND, curve: col.Curve = "smooth", weight: float = 1.0
    ) -> None:
        """Lays hands over the clips to which they are aligned. They replace other hands.

        A clip to which they are not aligned keeps its own hands. While two are still being blended, a third waits; a
        newer one replaces it.

        Args:
            rows: The characters.
            hands: Name of a hands clip; None for the clips' own hands.
            blend: Seconds to blend.
            curve: Shape of the blend, as in `play`.
            weight: Weight of these hands over the clips' own, 0 to 1.
        """
        self.state[rows, col.NEXT_HANDS : col.HOLDS] = waiting_hands(self.stage.bank, hands, blend, curve, weight)
        self.state[rows, col.HANDS_WAIT] = 1.0
        self._begin(rows)

    def look(self, rows: Rows, look: Look | None, *, blend: float = BLEND) -> None:
        """Turns head, neck and spine toward a target within `blend` seconds, in place of another; None ends it."""
        give_target(self.state, self._numbers(rows), ("head",), look, blend)

    def aim(self, rows: Rows, aim: Aim | None, *, blend: float = BLEND) -> None:
        """Turns a part of the body toward a target, as `look` does the head; None ends it for all parts."""
        give_target(self.state, self._numbers(rows), AIM_PARTS if aim is None else (aim.part,), aim, blend)

    def speed(self, rows: Rows, speed: float) -> None:
        """Sets the playback speed, 0 to 1e9; 1 is as captured."""
        self.state[rows, col.SPEED] = not_negative("speed", speed)

    def weight(self, rows: Rows, weight: float) -> None:
        """Sets the weight of the newest action, 0 to 1. Characters follow within about a tenth of a second."""
        fraction("weight", weight)
        for row in self._numbers(rows):
            if (slot := references.newest_action(self.state[row])) is not None:
                self.state[row, slot + col.GOAL] = weight

    def place(self, rows: Rows, position: Sequence[float], heading: float = 0.0) -> None:
        """Moves characters to a position [3] on the ground, metres, and a heading, radians about Y from Z."""
        if np.shape(position) != (3,) or not (np.abs([*position, heading]) <= FARTHEST).all():
            raise SettingsError(f"a position must be three numbers of at most {FARTHEST:g}, and a heading one")
        self.state[rows, col.PLACE : col.PLACE + 3] = position
        self.state[rows, col.HEADING] = heading
        self.state[rows, col.SIN], self.state[rows, col.COS] = np.sin(0.5 * heading), np.cos(0.5 * heading)

    def in_place(self, rows: Rows, in_place: bool = True) -> None:
        """Poses characters at the origin, facing Z, for games that apply `deltas` themselves."""
        self.state[rows, col.IN_PLACE] = in_place

    def rebase(self, rows: Rows, rebased: bool = True) -> None:
        """Poses characters relative to `origins`, so that float32 root positions stay precise far from the world's."""
        self.state[rows, col.REBASED] = rebased

    def lock_feet(self, rows: Rows, lock_feet: bool = True) -> None:
        """Holds standing feet in place, or no longer. The lock fades in or out within 0.2 seconds."""
        self.state[rows, col.LOCK] = lockable(self.stage.arrays.legs, lock_feet)

    def advance(self, frames: int = 1) -> int:
        """Advances all characters, by one frame if not given otherwise.

        In one step of several frames, what begins or ends does so at the end of the step. A step takes the same time
        however many frames it has, at most 1e12.

        Returns:
            The bits of all events that happened to any character (EVENT_NAMES); `events` has them by character.
        """
        if not 0 <= frames <= MOST_FRAMES:
            raise SettingsError(f"cannot advance by {frames} frames", mend=f"Advance by 0 to {MOST_FRAMES}")
        return int(self.stage._advance(self.stage._handle, self.state.reshape(-1), frames / self.rate))

    def evaluate(self, out: Poses) -> None:
        """Writes the n characters' poses into `out`, which must have room for exactly n. Raises SettingsError."""
        if out.flat.shape != (len(self), 4 * self.stage.bank.skeleton.joint_count):
            problem = f"{len(self)} characters need {len(self)} poses, found room for {len(out.flat)}"
            raise SettingsError(problem, mend="Create the poses with Evaluator.poses(len(characters))")
        work = (self.state.reshape(-1), self._share, out.root_positions, out.flat)
        self.stage._evaluate(self.stage._handle, *work)

    def remember(self) -> None:
        """Notes the poses of a frame that is not shown, which those of later frames depend on.

        It evaluates only characters that have an action of posture `running`. Where a torso allows no unique best
        rotation, others reuse that of the last frame that was shown.
        """
        rows = running_rows(self.state)
        if len(rows) > 0:
            some = copy.copy(self)
            some.state = self.state[rows]
            some.evaluate(self.stage.evaluator.poses(len(rows)))
            self.state[rows] = some.state

    def _begin(self, rows: Rows) -> None:
        clock_kernels.begin(self.stage._handle, self.state.reshape(-1), self._numbers(rows))

    def _wait(self, rows: Rows, slot: States, when: int) -> None:
        self.state[rows, col.NEXT_ACTION : col.NEXT_ACTION + col.ACTION_COLUMNS] = slot
        self.state[rows, col.WHEN] = when
        self._begin(rows)
