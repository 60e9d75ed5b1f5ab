"""The columns of a character's row: where it is, what it plays, and what is waiting.

A row is float64 numbers and nothing else, so a character is saved, copied and restored with its row. Columns that every
frame reads come first, so that a character without a transition touches few cache lines of its row. A character plays
three stacks of slots: locomotions, in groups that are mixed by weight; actions over them; hands over both. Each slot is
faded in over the slots below it. One group, one action and one hands slot may wait until they can begin. Over all of
them, four parts of the body may each be turned toward a target.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from motionsplice.motion.parts import MASKS as MASKS
from motionsplice.motion.parts import PARTS as PARTS
from motionsplice.motion.parts import TRUNK as TRUNK
from motionsplice.motion.parts import UPPER_BODY as UPPER_BODY
from motionsplice.motion.parts import Mask as Mask
from motionsplice.runtime.kernels.arrays import MEMORY_COLUMNS

MOST_MIXED = 4  # locomotions in a group
MOST_LOCOMOTIONS = 2 * MOST_MIXED  # slots: a group, and another that it is blended into
MOST_ACTIONS = 4  # slots
MOST_HANDS = 2  # slots

# position and heading (metres, radians about Y); root motion of the last step, relative to the previous place
PLACE, HEADING, DELTA = 0, 3, 4
SPEED, IN_PLACE, LOCOMOTIONS, ACTIONS = 8, 9, 10, 11
# bits of standing feet, bits of events, clips of the latest ACTION_BEGAN and ACTION_ENDED
STANDING, EVENTS, BEGAN, ENDED = range(12, 16)
SIN, COS = 16, 17  # sine and cosine of half the heading
# what few characters have: size of the waiting group, when the waiting action begins; number of hands, whether hands
# wait; whether the foot lock is on, how far it is faded in; number of parts that are turned; whether poses are relative
# to an origin nearby
NEXT_COUNT, WHEN, HANDS, HANDS_WAIT, LOCK, LOCKED, AIMED, REBASED = range(18, 26)

# a locomotion slot; the slots begin at FIRST_LOCOMOTION
CLIP, PHASE, FRAME, WEIGHT, LAGGING, GOAL, ELAPSED, LASTING, CURVE, HEAD, LOOP, SHARE = range(12)
PATH, PATH_SIN, PATH_COS = 12, 16, 17  # the clip's root path at the frame; sine and cosine of half its heading
LOCOMOTION_COLUMNS = 18
FIRST_LOCOMOTION = 26
# an action slot: CLIP to CURVE, LOOP and SHARE as above; HEAD is its kind
KIND, MASK, POSTURE, FADING_OUT, OWN_FROM, OWN_TO, LEAVING, REMEMBERED = HEAD, 12, 13, 14, 15, 16, 17, 18
ANY_PACE = -1.0  # in OWN_TO, of an action that is never by its own clock: it follows the legs however fast they are
PLAYS_ON = -1.0  # in LEAVING, above 0 for an action that fades out: a stretch of a hybrid that the next takes over from
ACTION_COLUMNS = REMEMBERED + MEMORY_COLUMNS
FIRST_ACTION = FIRST_LOCOMOTION + MOST_LOCOMOTIONS * LOCOMOTION_COLUMNS
# waiting: an action as a slot; a group: settings as in a slot, clips and weights
NEXT_ACTION = FIRST_ACTION + MOST_ACTIONS * ACTION_COLUMNS
NEXT_TIME = NEXT_ACTION + ACTION_COLUMNS
NEXT_LASTING, NEXT_CURVE, NEXT_LOOP, NEXT_CLIPS = range(NEXT_TIME + 1, NEXT_TIME + 5)
NEXT_WEIGHTS = NEXT_CLIPS + MOST_MIXED
# hands: slots, CLIP to CURVE as above, but CLIP is a hands clip or BARE; the waiting slot
FIRST_HANDS, HANDS_COLUMNS = NEXT_WEIGHTS + MOST_MIXED, CURVE + 1
NEXT_HANDS = FIRST_HANDS + MOST_HANDS * HANDS_COLUMNS
# foot lock: for each foot its offset x and z from the pose, relative to the heading, and for how long it has stood,
# seconds
HOLDS = NEXT_HANDS + HANDS_COLUMNS
HOLD_COLUMNS = 3
# for each part that is turned, what is wanted: the kind of target, point (metres) or direction in the world, weight,
# shares of spine and steadiness, limits (radians), duration of changes (seconds)
TARGET, TO, WANTED_WEIGHT, WANTED_SPINE, WANTED_STEADY, MOST_YAW, MOST_PITCH, SETTLING = 0, 1, 4, 5, 6, 7, 8, 9
# and what is shown: whether the target has changed since; the target's yaw and pitch from the heading; weight and
# shares, which follow those that are wanted, and by how much yaw and pitch still differ, each with two derivatives
CHANGED, YAW, PITCH, SHOWN, SPINE, STEADY, YAW_LEFT, PITCH_LEFT = 10, 11, 12, 13, 16, 19, 22, 25
AIM_COLUMNS = 28
FIRST_AIM = HOLDS + 2 * HOLD_COLUMNS
LINE = 8  # columns in a cache line
COLUMNS = LINE * -(-(FIRST_AIM + 4 * AIM_COLUMNS) // LINE)

BARE = -1  # the clip's own hands

OWN = 0  # kind of an action slot: the locomotion's own upper body; other kinds are NAIVE and SPLICE
NEVER, NOW, IN_PHASE, ON_LEFT, ON_RIGHT, ON_FOOT = range(6)
LINEAR, SMOOTH, EASE_IN, EASE_OUT = range(4)
NOTHING, DIRECTION, POINT = range(3)  # kinds of targets
CHEST, LEFT, RIGHT, GAZE = (FIRST_AIM + part * AIM_COLUMNS for part in range(4))  # what is turned toward a target
LEFT_DOWN, LEFT_UP, RIGHT_DOWN, RIGHT_UP, STRIDE, LOCOMOTION_ENDED, ACTION_BEGAN, ACTION_ENDED = (
    1 << bit for bit in range(8)
)

When = Literal["now", "phase", "left_foot", "right_foot", "foot"]
Curve = Literal["linear", "smooth", "ease_in", "ease_out"]
WHENS: Mapping[str, int] = {
    "now": NOW, "phase": IN_PHASE, "left_foot": ON_LEFT, "right_foot": ON_RIGHT, "foot": ON_FOOT,
}  # fmt: skip
CURVES: Mapping[str, int] = {"linear": LINEAR, "smooth": SMOOTH, "ease_in": EASE_IN, "ease_out": EASE_OUT}
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
"""Names of the event bits that `Characters.advance` and `Characters.events` report.

- `left_down`, `left_up`, `right_down`, `right_up`: a foot touches down or lifts off.
- `stride`: the phase passes a whole number.
- `locomotion_ended`: a locomotion without a loop has reached its last frame.
- `action_began`: an action begins.
- `action_ended`: an action without a loop has faded out.
"""
