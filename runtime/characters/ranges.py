"""The range of every column of a character's row, and the check of rows that come from outside.

Ranges are wide: everything that commands and kernels write lies in them, however long a character plays and however
fast. Within them every frame costs the same, and poses are finite.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.aim import FARTHEST, LARGEST_PITCH, LARGEST_YAW
from motionsplice.runtime.characters.clip_references import States, clip_references, hands_references
from motionsplice.runtime.characters.commands import MOST
from motionsplice.runtime.kernels.arrays import LAST_TURN, MEAN_POSTURE
from motionsplice.runtime.kernels.lookup import SPLICE
from motionsplice.runtime.kernels.posture import RUNNING

VAST = 1e36  # metres, frames, seconds, radians: what grows for as long as a character plays; finite in float32
FAR = 1e12  # metres, radians: places within a clip
ROUNDING = 1e-3  # of sums and lengths that are 1
MEND = "Was it saved with another bank, or changed since?"


class Range(NamedTuple):
    """The values that a column may hold: from `least` to `most`, whole numbers only if `whole`; NaN only if `unset`."""

    meaning: str
    least: float
    most: float
    whole: bool = False
    unset: bool = False


Ranges = Mapping[int, Range]


def several(first: int, count: int, one: Range) -> Ranges:
    return dict.fromkeys(range(first, first + count), one)


FADE: Ranges = {
    col.WEIGHT: Range("weight", 0.0, 1.0 + ROUNDING),
    col.LAGGING: Range("lagging weight", 0.0, 1.0 + ROUNDING),
    col.GOAL: Range("wanted weight", 0.0, 1.0 + ROUNDING),
    col.ELAPSED: Range("time since the fade began", 0.0, VAST),
    col.LASTING: Range("duration of the fade", 0.0, MOST),
    col.CURVE: Range("curve of the fade", col.LINEAR, col.EASE_OUT, whole=True),
}
PLAYED: Ranges = {
    col.CLIP: Range("clip", 0, FAR, whole=True),
    col.PHASE: Range("phase", -VAST, VAST),
    col.FRAME: Range("frame", 0.0, VAST),
    **FADE,
    col.LOOP: Range("loop", 0, 1, whole=True),
    col.SHARE: Range("share", 0.0, 1.0 + ROUNDING),
}
LOCOMOTION: Ranges = {
    **PLAYED,
    col.HEAD: Range("size of the group", 0, col.MOST_MIXED, whole=True),
    **several(col.PATH, 4, Range("root path", -FAR, FAR)),
    col.PATH_SIN: Range("sine of the root path's heading", -1.0, 1.0),
    col.PATH_COS: Range("cosine of the root path's heading", -1.0, 1.0),
}
ACTION: Ranges = {
    **PLAYED,
    col.KIND: Range("kind of the action", col.OWN, SPLICE, whole=True),
    col.MASK: Range("mask", 0, col.UPPER_BODY, whole=True),
    col.POSTURE: Range("posture", 0, RUNNING, whole=True),
    col.FADING_OUT: Range("duration of the fade-out", 0.0, MOST),
    col.OWN_FROM: Range("begin of the own clock", 0.0, np.inf),
    col.OWN_TO: Range("end of the own clock", col.ANY_PACE, np.inf),
    col.LEAVING: Range("whether the action ends", col.PLAYS_ON, 1, whole=True),
    **several(col.REMEMBERED + LAST_TURN, 4, Range("remembered turn", -1.0 - ROUNDING, 1.0 + ROUNDING)),
    **several(col.REMEMBERED + MEAN_POSTURE, 6, Range("remembered posture", -FAR, FAR, unset=True)),
}
HANDS: Ranges = {
    col.CLIP: Range("hands", col.BARE, FAR, whole=True),
    col.PHASE: Range("phase of hands", -VAST, VAST),
    col.FRAME: Range("frame of hands", 0.0, VAST),
    **FADE,
}
AIM: Ranges = {
    col.TARGET: Range("kind of the target", col.NOTHING, col.POINT, whole=True),
    **several(col.TO, 3, Range("target", -FARTHEST, FARTHEST)),
    col.WANTED_WEIGHT: Range("wanted weight of the target", 0.0, 1.0),
    col.WANTED_SPINE: Range("wanted share of the spine", 0.0, 1.0),
    col.WANTED_STEADY: Range("wanted steadiness", 0.0, 1.0),
    col.MOST_YAW: Range("largest yaw", 0.0, LARGEST_YAW),
    col.MOST_PITCH: Range("largest pitch", 0.0, LARGEST_PITCH),
    col.SETTLING: Range("duration of changes of the target", 0.0, MOST),
    col.CHANGED: Range("whether the target has changed", 0, 1, whole=True),
    **several(col.YAW, 2, Range("way to the target", -FAR, FAR)),
    **several(col.SHOWN, 9, Range("rate of a share of the target", -VAST, VAST)),
    **{column: Range("share of the target", 0.0, 1.0) for column in (col.SHOWN, col.SPINE, col.STEADY)},
    **several(col.YAW_LEFT, 6, Range("rest of the way to the target", -VAST, VAST)),
}
ROW: Ranges = {
    **several(col.PLACE, 3, Range("place", -VAST, VAST)),
    col.HEADING: Range("heading", -VAST, VAST),
    **several(col.DELTA, 4, Range("root motion", -VAST, VAST)),
    col.SPEED: Range("speed", 0.0, MOST),
    col.IN_PLACE: Range("in_place", 0, 1, whole=True),
    col.LOCOMOTIONS: Range("number of locomotions", 1, col.MOST_LOCOMOTIONS, whole=True),
    col.ACTIONS: Range("number of actions", 0, col.MOST_ACTIONS, whole=True),
    **several(col.STANDING, 2, Range("bits of feet and events", 0, 255, whole=True)),
    **several(col.BEGAN, 2, Range("clip of an event", 0, FAR, whole=True)),
    col.SIN: Range("sine of the heading", -1.0, 1.0),
    col.COS: Range("cosine of the heading", -1.0, 1.0),
    col.NEXT_COUNT: Range("number of waiting locomotions", 0, col.MOST_MIXED, whole=True),
    col.WHEN: Range("moment of the waiting action", col.NEVER, col.ON_FOOT, whole=True),
    col.HANDS: Range("number of hands", 0, col.MOST_HANDS, whole=True),
    col.HANDS_WAIT: Range("whether hands wait", 0, 1, whole=True),
    col.LOCK: Range("foot lock", 0, 1, whole=True),
    col.LOCKED: Range("fade of the foot lock", 0.0, 1.0),
    col.AIMED: Range("number of targets", 0, 4, whole=True),
    col.REBASED: Range("whether poses are relative to an origin nearby", 0, 1, whole=True),
    col.NEXT_TIME: Range("time of the waiting locomotions", 0.0, MOST),
    col.NEXT_LASTING: Range("duration of the waiting blend", 0.0, MOST),
    col.NEXT_CURVE: Range("curve of the waiting blend", col.LINEAR, col.EASE_OUT, whole=True),
    col.NEXT_LOOP: Range("loop of the waiting locomotions", 0, 1, whole=True),
    **several(col.NEXT_CLIPS, col.MOST_MIXED, Range("waiting clip", 0, FAR, whole=True)),
    **several(col.NEXT_WEIGHTS, col.MOST_MIXED, Range("weight of a waiting clip", 0.0, 1.0)),
    **{
        column: one
        for hold in (col.HOLDS, col.HOLDS + col.HOLD_COLUMNS)
        for column, one in {
            **several(hold, 2, Range("offset of a locked foot", -FAR, FAR)),
            hold + 2: Range("time that a foot has stood", 0.0, VAST),
        }.items()
    },
}
SLOTS = (  # the ranges of a slot, its first column, how many columns and slots there are
    (LOCOMOTION, col.FIRST_LOCOMOTION, col.LOCOMOTION_COLUMNS, col.MOST_LOCOMOTIONS),
    (ACTION, col.FIRST_ACTION, col.ACTION_COLUMNS, col.MOST_ACTIONS + 1),
    (HANDS, col.FIRST_HANDS, col.HANDS_COLUMNS, col.MOST_HANDS + 1),
    (AIM, col.FIRST_AIM, col.AIM_COLUMNS, 4),
)
RANGES: Ranges = {
    **ROW,
    **{
        first + number * width + column: one
        for slot, first, width, count in SLOTS
        for number in range(count)
        for column, one in slot.items()
    },
}
_COUNTS = (col.LOCOMOTIONS, col.ACTIONS, col.HANDS)  # of slots in use
_LEAST, _MOST = np.full(col.COLUMNS, -np.inf), np.full(col.COLUMNS, np.inf)
_WHOLE, _UNSET = np.zeros((2, col.COLUMNS), np.bool_)
for _column, _range in RANGES.items():
    _LEAST[_column], _MOST[_column], _WHOLE[_column], _UNSET[_column] = _range[1:]


def check_rows(state: States, clips: int, hands: int) -> None:
    """Raises SettingsError if a row of [n, COLUMNS] does not fit a bank with so many clips and hands."""
    if len(state) == 0:  # as of a new connection; the checks below take a fifth of a millisecond
        return
    for part, used in used_parts(state):
        if len(rows := np.flatnonzero(used)):
            values = state[rows, part]
            valid = (values >= _LEAST[part]) & (values <= _MOST[part]) & (~_WHOLE[part] | (values == np.floor(values)))
            row, column = np.nonzero(~(valid | (_UNSET[part] & np.isnan(values))))
            if len(row):
                value = values[row[0], column[0]]
                raise _invalid(int(rows[row[0]]), f"{RANGES[part.start + int(column[0])].meaning} is {value:g}")
    for (places, numbers), count, label in (
        (clip_references(state), clips, "clip"),
        (hands_references(state), hands, "hands"),
    ):
        unknown = np.flatnonzero(numbers >= count)
        if len(unknown):
            raise _invalid(int(places[0][unknown[0]]), f"{label} {numbers[unknown[0]]} of {count}")
    for meaning, fits in _relations(state):
        if not fits.all():
            raise _invalid(int(np.argmin(fits)), meaning)


def _invalid(row: int, problem: str) -> SettingsError:
    return SettingsError(f"row {row} is not a valid character state for this bank: {problem}", mend=MEND)


def used_parts(state: States) -> Iterator[tuple[slice, NDArray[np.bool_]]]:
    """Yields parts of rows [n, COLUMNS], and which rows [n] use them: other slots may be stale. Counts come first."""
    always = np.ones(len(state), np.bool_)
    yield slice(0, col.FIRST_LOCOMOTION), always
    yield slice(col.HOLDS, col.FIRST_AIM), always
    for (_, first, width, slots), count, waits in zip(SLOTS, _COUNTS, (None, col.WHEN, col.HANDS_WAIT), strict=False):
        for number in range(slots):
            is_waiting = waits is not None and number == slots - 1
            used = state[:, waits] > 0.0 if is_waiting else state[:, count] > number
            yield slice(first + number * width, first + (number + 1) * width), used
    for slot in (col.CHEST, col.LEFT, col.RIGHT, col.GAZE):
        yield slice(slot, slot + 1), always
        yield slice(slot + 1, slot + col.AIM_COLUMNS), state[:, slot + col.TARGET] != col.NOTHING
    yield slice(col.NEXT_TIME, col.NEXT_CLIPS), state[:, col.NEXT_COUNT] > 0.0
    for number in range(col.MOST_MIXED):
        for column in (col.NEXT_CLIPS + number, col.NEXT_WEIGHTS + number):
            yield slice(column, column + 1), state[:, col.NEXT_COUNT] > number


def _relations(state: States) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Yields what columns in their ranges must also fulfil together, and which rows [n] do."""
    slots = col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS * np.arange(col.MOST_LOCOMOTIONS)
    numbers, count = np.arange(col.MOST_LOCOMOTIONS), state[:, [col.LOCOMOTIONS]]
    used = numbers < count
    heads = np.where(used, state[:, slots + col.HEAD], 0.0)
    ends = np.maximum.accumulate(np.where(heads > 0.0, numbers + heads, 0.0), axis=1)
    begins = np.concatenate([np.ones((len(state), 1), np.bool_), ends[:, :-1] == numbers[1:]], axis=1)
    yield (
        "its locomotions do not form groups",
        ((heads > 0.0) == (begins & used)).all(axis=1) & (ends[:, -1] == count[:, 0]),
    )
    group_count = (heads > 0.0).sum(axis=1)
    for column in (col.SHARE, col.WEIGHT, col.LAGGING, col.GOAL):
        sums = np.where(used, state[:, slots + column], 0.0).sum(axis=1)
        whole = _is_near(sums, 1.0 if column == col.SHARE else group_count)
        yield f"the {LOCOMOTION[column].meaning}s of its locomotions do not add up", whole
    waits = numbers[: col.MOST_MIXED] < state[:, [col.NEXT_COUNT]]
    sums = np.where(waits, state[:, col.NEXT_WEIGHTS : col.NEXT_WEIGHTS + col.MOST_MIXED], 0.0).sum(axis=1)
    yield "the weights of its waiting locomotions do not add up", _is_near(sums, waits[:, 0])
    yield "sine and cosine of its heading do not fit", _is_unit(state[:, [col.SIN, col.COS]])
    paths = _is_unit(np.stack([state[:, slots + col.PATH_SIN], state[:, slots + col.PATH_COS]], axis=2))
    yield "sine and cosine of a root path's heading do not fit", np.asarray((paths | ~used).all(axis=1))
    actions = col.FIRST_ACTION + col.ACTION_COLUMNS * np.arange(col.MOST_ACTIONS + 1)
    turns = _is_unit(state[:, actions[:, None] + col.REMEMBERED + LAST_TURN + np.arange(4)])
    idle = state[:, actions + col.KIND] == col.OWN
    idle[:, :-1] |= np.arange(col.MOST_ACTIONS) >= state[:, [col.ACTIONS]]
    idle[:, -1] |= state[:, col.WHEN] == col.NEVER
    yield "a remembered turn is no rotation", (turns | idle).all(axis=1)


def _is_unit(vectors: States) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore", over="ignore"):  # of slots that are not in use
        return _is_near(np.square(vectors).sum(axis=-1), 1.0)


def _is_near(values: States, wanted: Any) -> NDArray[np.bool_]:
    return np.less_equal(abs(values - wanted), ROUNDING)
