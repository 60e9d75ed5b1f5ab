"""A character as a row of numbers: where it is, what it plays, and what comes next.

Rows are float64 and hold nothing but numbers, so a character is saved, copied and restored with its row. What it plays
are three stacks of slots, each slot faded in over those below it: locomotions, in groups that are mixed by weight,
actions over them, and hands over either. One of each may wait until it can begin.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from motionsplice.runtime.kernels.arrays import MEMORY_COLUMNS

MOST_MIXED = 4  # locomotions of a group
MOST_LOCOMOTIONS = 2 * MOST_MIXED  # slots: a group, and another that it is faded into
MOST_ACTIONS = 4  # slots
MOST_HANDS = 2  # slots

# where it stands (metres, radians about Y), and what the last step added to that, seen from there
PLACE, HEADING, DELTA = 0, 3, 4
SPEED, IN_PLACE, LOCOMOTIONS, ACTIONS = 8, 9, 10, 11
STANDING, EVENTS, BEGAN, ENDED = 12, 13, 14, 15  # feet; bits; clips that the events are about
SIN, COS = 16, 17  # of half the heading

# a slot of locomotion, from FIRST_LOCOMOTION on
CLIP, PHASE, FRAME, WEIGHT, LAGGING, GOAL, ELAPSED, LASTING, CURVE, HEAD, LOOP, SHARE = range(12)
PATH, PATH_SIN, PATH_COS = 12, 16, 17  # where the clip's path is at the frame; of half its heading
LOCOMOTION_COLUMNS = 18
FIRST_LOCOMOTION = 18
# a slot of action: the same up to CURVE, LOOP and SHARE; HEAD is its kind
KIND, MASK, POSTURE, FADING_OUT, OWN_FROM, OWN_TO, LEAVING, REMEMBERED = HEAD, 12, 13, 14, 15, 16, 17, 18
ACTION_COLUMNS = REMEMBERED + MEMORY_COLUMNS
FIRST_ACTION = FIRST_LOCOMOTION + MOST_LOCOMOTIONS * LOCOMOTION_COLUMNS
# what waits: an action as a slot, and when it begins; a group, its clips and weights, and the rest as of a slot
NEXT_ACTION = FIRST_ACTION + MOST_ACTIONS * ACTION_COLUMNS
WHEN = NEXT_ACTION + ACTION_COLUMNS
NEXT_COUNT, NEXT_TIME, NEXT_LASTING, NEXT_CURVE, NEXT_LOOP = range(WHEN + 1, WHEN + 6)
NEXT_CLIPS = WHEN + 6
NEXT_WEIGHTS = NEXT_CLIPS + MOST_MIXED
# hands: how many slots, and these, of which CLIP is a number of hands or BARE, the rest as of a slot; and what waits
HANDS = NEXT_WEIGHTS + MOST_MIXED
FIRST_HANDS, HANDS_COLUMNS = HANDS + 1, CURVE + 1
NEXT_HANDS = FIRST_HANDS + MOST_HANDS * HANDS_COLUMNS
HANDS_WAIT = NEXT_HANDS + HANDS_COLUMNS
COLUMNS = HANDS_WAIT + 1

BARE = -1  # no hands but the body's own

OWN = 0  # the kind of an action that is the locomotion's own upper body; others are as methods are numbered
NEVER, NOW, IN_PHASE, ON_LEFT, ON_RIGHT, ON_FOOT = range(6)
LINEAR, SMOOTH, EASE_IN, EASE_OUT = range(4)
TRUNK, LEFT_ARM, RIGHT_ARM, HEAD_AND_NECK = 1, 2, 4, 8  # parts of an upper body
PARTS = 4
UPPER_BODY = 15
LEFT_DOWN, LEFT_UP, RIGHT_DOWN, RIGHT_UP, STRIDE, LOCOMOTION_ENDED, ACTION_BEGAN, ACTION_ENDED = (
    1 << bit for bit in range(8)
)

When = Literal["now", "phase", "left_foot", "right_foot", "foot"]
Curve = Literal["linear", "smooth", "ease_in", "ease_out"]
Mask = Literal["upper_body", "left_arm", "right_arm", "arms", "head"]
WHENS: Mapping[str, int] = {
    "now": NOW, "phase": IN_PHASE, "left_foot": ON_LEFT, "right_foot": ON_RIGHT, "foot": ON_FOOT,
}  # fmt: skip
CURVES: Mapping[str, int] = {"linear": LINEAR, "smooth": SMOOTH, "ease_in": EASE_IN, "ease_out": EASE_OUT}
MASKS: Mapping[str, int] = {
    "upper_body": UPPER_BODY,
    "left_arm": LEFT_ARM,
    "right_arm": RIGHT_ARM,
    "arms": LEFT_ARM | RIGHT_ARM,
    "head": HEAD_AND_NECK,
}
EVENT_NAMES: Mapping[int, str] = {
    LEFT_DOWN: "left_down",
    LEFT_UP: "left_up",
    RIGHT_DOWN: "right_down",
    RIGHT_UP: "right_up",
    STRIDE: "stride",
    LOCOMOTION_ENDED: "locomotion_ended",
    ACTION_BEGAN: "action_began",
    ACTION_ENDED: "action_ended",
}
