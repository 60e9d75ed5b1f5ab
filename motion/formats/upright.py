"""Makes Y up in clips of files in which it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.body_shape import axis_at_rest, sampled_positions, standing_axis
from motionsplice.motion.clip import Clip
from motionsplice.motion.clip_settings import AXES
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles

TURNS = {  # by the axis that is up: the rotation that makes Y up
    "x": quaternion.about([0.0, 0.0, 1.0], np.pi / 2.0),  # (x, y, z) -> (-y, x, z)
    "y": quaternion.IDENTITY,
    "z": quaternion.about([1.0, 0.0, 0.0], -np.pi / 2.0),  # (x, y, z) -> (x, z, -y)
    "-x": quaternion.about([0.0, 0.0, 1.0], -np.pi / 2.0),
    "-y": quaternion.about([1.0, 0.0, 0.0], np.pi),  # cameras look along Z with Y down
    "-z": quaternion.about([1.0, 0.0, 0.0], np.pi / 2.0),
}


def check_up(up: str | None) -> None:
    """Raises SettingsError unless `up` is an axis, or None for one that is to be found."""
    if up is not None and up not in AXES:
        raise SettingsError(f"{up!r} is not an axis that can be up", mend=f"Use {', '.join(AXES)}")


def made_upright(clip: Clip, roles: Roles, up: str | None) -> tuple[Clip, list[str], list[str]]:
    """Turns a clip, as its file has it, so that Y is up and its bind pose stands along Y.

    Args:
        clip: The clip, with the file's axes.
        roles: Its roles.
        up: The axis that is up in the file. None to find it: the one along which the bind pose stands, but for a
            motion that stands along Y. Then only the bind pose is turned. A motion alone proves nothing, as a body may
            lie.

    Returns:
        The clip, notes and warnings for the user.
    """
    bind = axis_at_rest(clip.skeleton, roles) or "y"
    found = up or ("y" if bind == "y" or standing_axis(sampled_positions(clip), roles) == "y" else bind)
    if bind == found == "y":
        return clip, [], []
    notes, warnings = list[str](), list[str]()
    if up is None and found != "y":
        notes.append(f"{found.upper()} is up in the file: turned to Y up. If it is not, give --up y")
    elif up is None:
        doubt = f"the bind pose stands along {bind.upper()}, but the motion along Y, so Y is taken to be up"
        warnings.append(f"{doubt}. If {bind.upper()} is up in the file, give --up {bind}")
    elif bind not in ("y", up):
        notes.append(f"the bind pose stands along {bind.upper()}: turned to stand along Y")
    return turned(clip, TURNS[bind], TURNS[found]), notes, warnings


def turned(clip: Clip, bind: Floats, world: Floats) -> Clip:
    """Returns a clip with its bind pose turned by the rotation `bind` [4] and its world by `world` [4].

    Joints move as before in the world, turned by `world`.
    """
    skeleton, back = clip.skeleton, quaternion.conjugate(bind)
    offsets, ends = quaternion.rotate(bind, skeleton.offsets), quaternion.rotate(bind, skeleton.end_offsets)
    rotations = quaternion.multiply(quaternion.multiply(bind, clip.rotations), back)
    rotations[:, 0] = quaternion.multiply(quaternion.multiply(world, clip.rotations[:, 0]), back)
    return replace(
        clip,
        skeleton=replace(skeleton, offsets=offsets, end_offsets=ends),
        root_positions=quaternion.rotate(world, clip.root_positions),
        rotations=rotations,
    )
