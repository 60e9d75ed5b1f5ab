"""The shape of a body: along which axis it stands, and whether the roles of its joints fit it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.clip_settings import AXES
from motionsplice.motion.errors import RoleError
from motionsplice.motion.kinematics import bind_positions, world_transforms
from motionsplice.motion.quaternion import Floats, unit
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton

RATE = 10.0  # frames per second at which a motion is looked at
UPRIGHT = 0.75  # cosine: a body stands along an axis if its trunk and its legs are within 41 degrees of it
LEVEL = 0.5  # cosine: a trunk within 30 degrees of the ground
CROSSED = "left and right are crossed between hips and shoulders"  # whichever axis is up
REACH = 0.35  # of the legs' length: hands that are less above the feet reach the ground


def sampled_positions(clip: Clip) -> Floats:
    """Returns the world positions [F, J, 3] of a clip's joints, about ten times a second."""
    frames = slice(None, None, max(1, int(clip.rate / RATE)))
    return world_transforms(clip.skeleton, clip.root_positions[frames], clip.rotations[frames])[0]


def standing_axis(positions: Floats, roles: Roles) -> str:
    """Returns the one of AXES along which a body stands in most frames, or "" if it stands along none.

    It stands along an axis if its trunk points up it and its legs down it. positions: [F, J, 3] of its joints.
    """
    trunk, legs = _trunk_and_legs(positions, roles)
    upwards, downwards = _median(trunk), _median(legs)
    along = np.minimum([*upwards, *-upwards], [*-downwards, *downwards])
    return AXES[int(np.argmax(along))] if along.max() > UPRIGHT else ""


@lru_cache(maxsize=16)  # the clips of a bank are of few rigs
def axis_at_rest(skeleton: Skeleton, roles: Roles) -> str:
    """Returns the `standing_axis` of the bind pose."""
    return standing_axis(bind_positions(skeleton)[None], roles)


def check_shape(clip: Clip, roles: Roles, given: bool, up_known: bool = False) -> list[str]:
    """Returns warnings about a body that does not stand upright along Y.

    A pose counts as upright if knees are below hips, shoulders above the pelvis, and the left shoulder is on the left
    hip's side. Someone may lie or crawl, so only the bind pose shows whether roles fit.

    Args:
        clip: The clip, with Y up.
        roles: The roles of its joints.
        given: Whether the user or the file named joints. Roles that were only guessed have to fit.
        up_known: Whether Y is certainly up, so that `--up` is not proposed.

    Raises:
        RoleError: The roles fit neither the bind pose nor the motion, the body stands on all fours at rest, or it is
            unclear whether it lies: the bind pose stands along no axis, and the motion along another one than Y.
    """
    moving = sampled_positions(clip)
    if not given and _on_all_fours(clip.skeleton, roles):
        problem = "this is not a human body: in the bind pose it stands on all fours"
        raise RoleError(problem, mend="If it is one, name its joints in a file and pass it as --roles")
    stands = standing_axis(moving, roles)
    axis = "" if stands == "y" else stands
    problem = _problem(moving, roles) or (f"it lies along {axis.upper()}" if axis else "")
    if not problem:
        return []
    is_up = f"{axis.upper()} is up in the file, give --up {axis}" if axis else "Y is not up in the file, give --up"
    hint = "" if up_known or problem == CROSSED else f"If {is_up}"
    shows_up = bool(axis_at_rest(clip.skeleton, roles))  # LAFAN1's bind pose, along one axis, does not
    lies = not shows_up and stands != "y"
    if given and problem == CROSSED:
        return [f"{problem}. Check left and right in the roles file, or in the humanoid of a VRM file"]
    if given or not _problem(bind_positions(clip.skeleton)[None], roles) or (lies and (up_known or not axis)):
        return [f"the body is not upright in most frames: {problem}" + (f". {hint}" if hint else "")]
    if lies and problem != CROSSED:
        problem = f"it is unclear which axis is up: the body stands along {axis.upper()}, and the bind pose along none"
        raise RoleError(problem, mend=f"{hint}. If Y is, give --up y")
    name_them = "name the joints in a file and pass it as --roles"
    raise RoleError(
        f"the roles do not fit the body, neither in the bind pose nor in the motion: {problem}",
        mend=f"{hint}. If not, {name_them}" if hint else name_them.capitalize(),
    )


def _problem(positions: Floats, roles: Roles) -> str:
    """Returns in what a body is not upright along Y in the median frame; "" if it is. positions: [F, J, 3]."""
    joints = (roles.pelvis, *_hips(roles), roles.left_knee, roles.right_knee, roles.left_shoulder, roles.right_shoulder)
    heights = dict(zip(joints, _median(positions[:, joints, 1] - positions[:, :1, 1]), strict=True))
    hips = positions[:, roles.left_hip] - positions[:, roles.right_hip]
    shoulders = positions[:, roles.left_shoulder] - positions[:, roles.right_shoulder]
    fits = {
        "the left knee is above the left hip": heights[roles.left_knee] < heights[roles.left_hip],
        "the right knee is above the right hip": heights[roles.right_knee] < heights[roles.right_hip],
        "the left shoulder is below the pelvis": heights[roles.left_shoulder] > heights[roles.pelvis],
        "the right shoulder is below the pelvis": heights[roles.right_shoulder] > heights[roles.pelvis],
        CROSSED: _median(np.sum(hips * shoulders, axis=1)) > 0.0,
    }
    return next((problem for problem, fit in fits.items() if not fit), "")


@lru_cache(maxsize=16)
def _on_all_fours(skeleton: Skeleton, roles: Roles) -> bool:
    """Returns whether at rest the trunk is level above legs, with the hands down where the feet are, whatever is up."""
    bind = bind_positions(skeleton)[None]
    trunk, legs = (vectors[0] for vectors in _trunk_and_legs(bind, roles))
    hands = _middle(bind, roles.left_wrist, roles.right_wrist)[0]
    feet, hips = (_middle(bind, *pair)[0] for pair in (_ankles(roles), _hips(roles)))
    above = float((feet - hands) @ legs)
    return abs(float(trunk @ legs)) < LEVEL and above < REACH * float(np.linalg.norm(feet - hips))


def _trunk_and_legs(positions: Floats, roles: Roles) -> tuple[Floats, Floats]:
    """Returns the directions [F, 3] from the hips to the shoulders, and from the hips to the ankles."""
    hips = _middle(positions, *_hips(roles))
    trunk = _middle(positions, roles.left_shoulder, roles.right_shoulder) - hips
    legs = _middle(positions, *_ankles(roles)) - hips
    return unit(trunk), unit(legs)


def _median(values: Floats) -> Floats:
    """Returns the median over the first axis, as `np.median`, which takes several times as long for few values."""
    ordered = np.sort(values, axis=0)
    return np.asarray(0.5 * (ordered[(len(values) - 1) // 2] + ordered[len(values) // 2]))


def _hips(roles: Roles) -> tuple[int, int]:
    return roles.left_hip, roles.right_hip


def _ankles(roles: Roles) -> tuple[int, int]:
    return roles.left_ankle, roles.right_ankle


def _middle(positions: Floats, left: int, right: int) -> Floats:
    return np.asarray(0.5 * (positions[:, left] + positions[:, right]))
