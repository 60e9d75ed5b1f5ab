"""The seam: frames added after a clip's end that lead back by a whole number of strides, so that the clip loops.

A clip with a gait can repeat whole strides, but no two strides are exactly alike. The last frame's counterpart is the
frame about a whole number of strides before it whose pose is nearest. The seam copies the frames after the counterpart,
and adds an offset that continues the clip's end in pose and velocity and fades to zero within the seam; so does the
rest of the phase. The root moves so that the foot that stands in the copied frames does not slide while the offset
fades. The clip's own frames do not change.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.contacts import support
from motionsplice.precompute.body.joint_paths import joint_paths
from motionsplice.precompute.preparation.feet import feet_over_ground, root_steps

SEAM = 0.3  # seconds
BEFORE = 0.05  # seconds before the clip's end that say how fast it ends: of captures, single frames are noisy
NEAR = 0.05  # strides: how far a counterpart may be from a whole number of strides
HURRY = 0.2  # of the seam's own strides, also a bound on that distance: the phase gains or loses it within the seam
TRIED = 21  # counterparts, for each number of strides
WIDEST_GAP = 0.5  # radians, root-mean-square over joints, from the last frame to its counterpart
LEVEL = 0.17  # leg lengths: a smaller rise per loop is taken out, so that it does not add up over many loops
SURE = 1e-9  # radians: more than rounding adds to a gap
WIDEST_TURN = 1.2  # radians of any single joint, from the last frame to its counterpart
NEWCOMER = 0.3  # how much a foot that touches down in the seam counts, beside one that stands at its beginning
ABOUT_AS_GOOD = 1.25  # times the least gap: the longest loop within this is used
GOOD = 0.25  # radians: a gap that the seam hides
MANY = 3  # strides: a loop of so many is used whenever its gap is GOOD, as fewer over and over look monotonous


@dataclass(frozen=True, eq=False)
class Seamed:
    """A clip followed by its seam.

    clip: its own frames, then the seam's. phase: [rows] cycles. strides: how many strides the end goes back; 0 if no
    usable loop was found, and then there is no seam.
    """

    clip: Clip
    phase: Floats
    strides: int


def add_seam(clip: Clip, phase: Floats, roles: Roles, standing: NDArray[np.uint8]) -> Seamed:
    """Adds a seam to a clip at `phase` [F], in cycles. Root motion continues in the direction of the last frame.

    standing: its `foot_contacts` [F].
    """
    strides, counterparts, gaps = _nearest_counterparts(clip, phase)
    if gaps.min(initial=np.inf) > WIDEST_GAP:
        return Seamed(clip, phase, 0)
    longest = np.flatnonzero((gaps <= ABOUT_AS_GOOD * gaps.min()) | ((gaps <= GOOD) & (strides >= MANY)))[-1]
    return _seamed(clip, phase, float(counterparts[longest]), int(strides[longest]), roles, standing)


def _nearest_counterparts(clip: Clip, phase: Floats) -> tuple[NDArray[np.intp], Floats, Floats]:
    """Returns usable numbers of strides [n], for each the counterpart [n] with the nearest pose, and its gap [n]."""
    last, count = clip.frame_count - 1, _seam_frames(clip)
    strides = np.arange(1, int(phase[-1] - phase[0]) + 1)
    near = min(NEAR, HURRY * (phase[-1] - phase[max(0, last - count)]))
    wanted = phase[-1] - strides[:, None] + np.linspace(-near, near, TRIED)
    tried = np.interp(wanted, phase, np.arange(last + 1))
    usable = (wanted[:, TRIED // 2] >= phase[0]) & (tried >= 1.0).any(axis=1) & (tried <= last - count).any(axis=1)
    strides, tried = strides[usable], tried[usable]
    gaps = np.full(tried.shape, np.inf)
    worth = _perhaps_nearest(clip, tried, (tried >= 1.0) & (tried <= last - count))
    gaps[worth] = _gaps(clip, tried[worth])
    rows, best = np.arange(len(strides)), gaps.argmin(axis=1)
    return strides, tried[rows, best], gaps[rows, best]


def _perhaps_nearest(clip: Clip, tried: Floats, allowed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Returns which counterparts [n, k] may be the nearest of a row: but for SURE, no allowed one is nearer."""
    gaps, widest = rough_gaps(clip.rotations, tried.ravel())
    gaps, widest = gaps.reshape(tried.shape), widest.reshape(tried.shape)
    usable = np.where(allowed & (widest <= WIDEST_TURN - SURE), gaps, np.inf)
    nearest = usable.min(axis=1, initial=np.inf, keepdims=True)
    return np.asarray(allowed & (widest <= WIDEST_TURN + SURE) & (gaps <= nearest + SURE))


@compiled(nogil=True, error_model="numpy")
def rough_gaps(rotations: Floats, frames: Floats) -> tuple[Floats, Floats]:
    """Returns the gaps [n] of `_gaps`, up to rounding, and the widest turn [n] of a joint, for real-valued frames [n].

    rotations: [F, J, 4] of a clip of two frames or more.
    """
    count, joints = rotations.shape[0], rotations.shape[1]
    gaps, widest, at = np.empty(len(frames)), np.zeros(len(frames)), np.empty(4)
    for k in range(len(frames)):
        before = min(int(frames[k]), count - 2)
        t, squares = frames[k] - before, 0.0
        for joint in range(1, joints):
            a, b, last = rotations[before, joint], rotations[before + 1, joint], rotations[count - 1, joint]
            near, far = 0.0, 0.0  # squares of the difference and the sum of both, in one hemisphere
            for i in range(4):
                near += (b[i] - a[i]) ** 2
                far += (b[i] + a[i]) ** 2
            sign = 1.0 if near <= far else -1.0
            angle = 2.0 * np.arctan2(np.sqrt(min(near, far)), np.sqrt(max(near, far)))
            first, second = 1.0 - t, t
            if angle > 1e-6:
                first, second = np.sin((1.0 - t) * angle), np.sin(t * angle)
            for i in range(4):
                at[i] = first * a[i] + sign * second * b[i]
            x = at[3] * last[0] - at[0] * last[3] - at[1] * last[2] + at[2] * last[1]
            y = at[3] * last[1] - at[1] * last[3] - at[2] * last[0] + at[0] * last[2]
            z = at[3] * last[2] - at[2] * last[3] - at[0] * last[1] + at[1] * last[0]
            w = at[0] * last[0] + at[1] * last[1] + at[2] * last[2] + at[3] * last[3]
            turn = 2.0 * np.arctan2(np.sqrt(x * x + y * y + z * z), abs(w))
            widest[k] = max(widest[k], turn)
            squares += turn * turn
        gaps[k] = np.sqrt(squares / max(joints - 1, 1))
    return gaps, widest


def add_seam_to_start(clip: Clip, stride: float, roles: Roles, standing: NDArray[np.uint8]) -> Seamed | None:
    """Adds a seam to a clip without a gait that leads back to its start; None if it ends in another pose.

    Such a clip has no phase of its own, so its phase becomes even, with a whole number of strides of about `stride`
    seconds in a repetition.
    """
    last, start = clip.frame_count - 1, np.array([1.0])
    if last - _seam_frames(clip) < start[0] or _gaps(clip, start)[0] > WIDEST_GAP:
        return None
    strides = max(1, round((last - start[0]) / clip.rate / stride))
    return _seamed(clip, strides * np.arange(last + 1.0) / (last - start[0]), start[0], strides, roles, standing)


def _gaps(clip: Clip, counterparts: Floats) -> Floats:
    """Returns how far the pose at each counterpart [...] is from the last frame's, radians; infinite if too far."""
    turns = quaternion.angle(clip.sampled(counterparts.ravel())[1][:, 1:], clip.rotations[-1, 1:])
    gaps = np.where(turns.max(axis=1, initial=0.0) <= WIDEST_TURN, np.sqrt(np.mean(turns**2, axis=1)), np.inf)
    return gaps.reshape(counterparts.shape)


def _seam_frames(clip: Clip) -> int:
    return max(2, round(SEAM * clip.rate))


def _seamed(
    clip: Clip, phase: Floats, counterpart: float, back: int, roles: Roles, standing: NDArray[np.uint8]
) -> Seamed:
    """Adds the seam that leads from the last frame to its counterpart, `back` strides before it."""
    after = counterpart + np.arange(1.0, _seam_frames(clip) + 1.0)
    firmness = support(standing, clip.rate)
    positions, rotations = _carried_on(clip, counterpart, after, firmness, roles)
    along = np.arange(clip.frame_count)
    apart = phase[-1] - back - np.interp(counterpart, along, phase)
    going_on = np.interp(after, along, phase) + back + settled(np.array([apart, apart]), len(after))
    return Seamed(clip.followed_by(positions, rotations), np.concatenate([phase, going_on]), back)


def _carried_on(clip: Clip, counterpart: float, after: Floats, firmness: Floats, roles: Roles) -> tuple[Floats, Floats]:
    """Returns root positions and rotations of the frames `after` the counterpart, continuing the clip's end.

    firmness: [F, 2] of `support`.
    """
    before = max(1, min(round(BEFORE * clip.rate), int(counterpart)))
    positions, rotations = clip.sampled(np.concatenate([counterpart + np.arange(-before, 1.0), after]))
    ends = clip.frames(clip.frame_count - 1 - before, clip.frame_count)
    there = _moved(clip, positions[before : before + 1], rotations[before : before + 1])
    turn = quaternion.about([0.0, 1.0, 0.0], _heading(ends, roles) - _heading(there, roles))
    climbed = ends.root_positions[-1, 1] - positions[before, 1]
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    positions = quaternion.rotate(turn, positions - positions[before]) + ends.root_positions[-1]
    if abs(climbed) < LEVEL * roles.leg_length(clip.skeleton):
        positions[:, 1] -= climbed
    rise = (ends.root_positions - positions[: before + 1])[:, 1]
    positions[before + 1 :, 1] += settled(rise, len(after))
    bent = bent_onto(ends.rotations, rotations)
    copied = _moved(clip, positions[before:], rotations[before:])
    laid = _moved(clip, copied.root_positions, np.concatenate([ends.rotations[-1:], bent]))
    slips = np.diff(feet_over_ground(laid, roles) - feet_over_ground(copied, roles), axis=0)
    positions[before + 1 :, [0, 2]] += np.cumsum(_against(slips, firmness, after), axis=0)
    return positions[before + 1 :], bent


def _against(slips: Floats, firmness: Floats, after: Floats) -> Floats:
    """Returns steps [n, 2] of the root against the slips [n, 2, 2] of the feet on the way to the frames `after` [n].

    firmness: [F, 2] of `support`. A foot that stands at the clip's end has been there for longer, and counts more than
    one that touches down later.
    """
    on_the_way = [np.interp(after - 0.5, np.arange(len(firmness)), foot) for foot in firmness.T]
    return root_steps(slips, np.stack(on_the_way, axis=1), NEWCOMER + (1.0 - NEWCOMER) * firmness[-1])


def bent_onto(ends: Floats, rotations: Floats) -> Floats:
    """Returns rotations [n, J, 4] that continue those in `ends` [k, J, 4], of two frames or more.

    They are rotations[k:], with an offset that makes rotations[:k] agree with `ends` and then fades out. `rotations` is
    [k + n, J, 4].
    """
    bend = quaternion.log(quaternion.multiply(quaternion.conjugate(rotations[: len(ends)]), ends))
    return quaternion.multiply(rotations[len(ends) :], quaternion.exp(settled(bend, len(rotations) - len(ends))))


def settled(offset: Floats, count: int) -> Floats:
    """Fades an offset, known at successive frames [k, ...], to zero smoothly over the next `count` frames.

    It goes on from its last value, with its mean velocity.
    """
    velocity = (offset[-1] - offset[0]) / (len(offset) - 1)
    t = (np.arange(1.0, count + 1.0) / count).reshape((-1, *[1] * (offset.ndim - 1)))
    return (2.0 * t**3 - 3.0 * t**2 + 1.0) * offset[-1] + (t**3 - 2.0 * t**2 + t) * count * velocity


def _moved(clip: Clip, positions: Floats, rotations: Floats) -> Clip:
    """Returns frames made of a clip's own, only to be measured."""
    return Clip.of_valid(clip.name, clip.skeleton, clip.rate, positions, rotations)


def _heading(clip: Clip, roles: Roles) -> float:
    """Returns the heading of the hips in a clip's last frame, radians about Y."""
    left, right = joint_paths(clip, (roles.left_hip, roles.right_hip))[-1]
    return float(heading(left - right))
