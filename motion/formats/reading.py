"""Reads a motion file of any supported format as a clip, with the roles of its joints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.body_shape import check_shape
from motionsplice.motion.clip import Clip
from motionsplice.motion.clip_settings import ClipSettings
from motionsplice.motion.errors import FormatError, MotionError, RoleError, SettingsError, did_you_mean
from motionsplice.motion.formats.files import Read, clip_name, clips_in, parse
from motionsplice.motion.formats.fold import Folded, Nodes, fold
from motionsplice.motion.formats.parsed import Parsed
from motionsplice.motion.formats.units import check_stated_unit, guess_unit, metres_per_unit
from motionsplice.motion.formats.upright import check_up, made_upright
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import (
    ENDS,
    LIMBS,
    NOTHING_GIVEN,
    GivenRole,
    Roles,
    check_limbs,
    common_ancestor,
    find_roles,
    limbs_by_name,
)
from motionsplice.motion.skeleton import shared, subtree
from motionsplice.motion.storage.place import Place, place_of

# The first frame is a bind pose if the step after it, in mean radians over the joints, exceeds this and is more than
# twice as large as any other step.
JUMP = 0.1

SHORTEST_LEG, LONGEST_LEG = 0.3, 2.5  # metres: with other legs, a file is not in the unit that it states


@dataclass(frozen=True, eq=False)
class Reading:
    """A motion file as it was read.

    Attributes:
        clip: The motion, in metres, with the root as joint 0.
        roles: The roles of the rig's joints.
        unit: The metres in the file's unit of length, as given, stated in the file, or guessed.
        notes: What was changed or assumed, such as joints left out or the unit guessed.
        warnings: Problems that will spoil a splice unless they are fixed, such as a leading bind pose.
    """

    clip: Clip
    roles: Roles
    unit: float
    notes: tuple[str, ...]
    warnings: tuple[str, ...]


def read_clip(
    path: str | PathLike[str] | Place,
    *,
    animation: str | None = None,
    skip_frames: int = 0,
    unit: str | None = None,
    up: str | None = None,
    rate: float | None = None,
    root: str | None = None,
    mirror: bool = False,
    roles: Mapping[str, GivenRole] = NOTHING_GIVEN,
) -> Reading:
    """Reads a BVH, AMC, FBX or glTF file (.glb, .gltf, .vrm, .vrma).

    FBX files need the extra `motionsplice[fbx]`.
    The skeleton of an AMC file is the ASF file in the same folder: `16.asf` for `16_15.amc`, or else the only one.
    Joints above the root, at which legs and trunk branch, are folded into its motion; joints that do not descend
    from it are left out.

    Args:
        path: The file, or its URL, such as `s3://bucket/walk.bvh`.
        animation: The name of the animation, for a glTF or FBX file that has several.
        skip_frames: The number of leading frames to leave out because they are not motion, such as a T-pose.
        unit: The file's unit of length: "m", "dm", "cm", "mm", "in", "ft", "cmu" (0.0254 / 0.45 m), or metres per unit
            as a number. None to use the one stated in the file, or else the one that gives the legs an adult's length.
        up: The axis that is up in the file, "x", "y", "z", "-x", "-y" or "-z". None for the one that the format
            defines, or else along which the bind pose stands.
        rate: Frames per second, if the file states it wrongly. The frames stay what they are.
        root: The root of the body to read, or any joint above its legs and arms, in a file with several bodies.
        mirror: Whether to exchange left and right.
        roles: Joint names by role, for joints that cannot be found by name; see `find_roles`.

    Returns:
        The clip, its roles, and notes and warnings for the user.

    Raises:
        FormatError: The file or its skeleton file is missing, malformed or of an unsupported type.
        ClipError: The motion is invalid, for example not finite.
        RoleError: The roles of the joints cannot be found, or `root` is not a joint.
        SettingsError: The unit, the axis or a role is unknown, or the rate is not positive.
        SkeletonError: The clip is to be mirrored, and a limb has a joint that the other side does not have.

    Example:
        ```python
        from pathlib import Path
        from motionsplice import dump_bvh, read_clip
        from motionsplice.motion.procedural.library import make

        Path("walk.bvh").write_bytes(dump_bvh(make("walk"), unit=0.01))
        reading = read_clip(Path("walk.bvh"), unit="cm")
        print(reading.clip.frame_count, reading.clip.rate, reading.warnings)
        ```
    """
    asked = ClipSettings(skip_frames=skip_frames, unit=unit, up=up, rate=rate, root=root, mirror=mirror, roles=roles)
    return read_as(asked, place_of(path), animation)


def read_as(asked: ClipSettings, path: Place, animation: str | None, read: Read | None = None) -> Reading:
    """Reads a clip as `read_clip` does, with its settings. read: instead of `read_bytes`, for all files."""
    check_up(asked.up)
    if asked.rate is not None and not 0.0 < asked.rate < math.inf:
        raise SettingsError(f"a rate of {asked.rate:g} frames per second", mend="Give a number above 0")
    return _read(path, animation, asked, still=False, read=read)


def read_rig(path: Place, roles: Mapping[str, GivenRole] = NOTHING_GIVEN) -> Reading:
    """Reads a file for its rig: a motion file, or a character without a motion, which gives one frame at rest.

    Raises as `read_clip` does.
    """
    animation, *_ = clips_in(path).values()  # all are of one rig
    return _read(path, animation, ClipSettings(roles=roles), still=True)


def _read(path: Place, animation: str | None, asked: ClipSettings, *, still: bool, read: Read | None = None) -> Reading:
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # Skeleton and Clip reject numbers that are not finite
            return _understood(path, animation, asked, parse(path, animation, asked.root, still=still, read=read))
    except MotionError as error:
        raise error.within(str(path)) from None


def _understood(path: Place, animation: str | None, asked: ClipSettings, parsed: Parsed) -> Reading:
    nodes, given = parsed.nodes, {**parsed.roles, **asked.roles}
    if not 0 <= asked.skip_frames < len(nodes.rotations):
        problem = f"cannot skip {asked.skip_frames} of {len(nodes.rotations)} frames"
        raise FormatError(problem, mend="Choose a smaller --skip-frames")
    folded = fold(nodes, root_of(nodes, asked.root, given))
    roles = find_roles(folded.skeleton, given)
    notes, warnings = [*parsed.notes, *folded.notes], list(parsed.warnings)
    notes += [] if asked.root else _other_body(nodes, folded.skeleton.names)
    leg = roles.leg_length(folded.skeleton)
    if asked.unit is not None:
        metres = metres_per_unit(asked.unit)
    elif parsed.unit is not None and SHORTEST_LEG <= parsed.unit * leg <= LONGEST_LEG:
        metres = parsed.unit
        warnings += check_stated_unit(metres, leg)
    else:
        metres, note, warning = guess_unit(leg)
        notes.append(note)
        warnings += [warning] if warning else []
    read = _clip(clip_name(path, animation), folded, float(asked.rate or parsed.rate), metres, asked.skip_frames)
    clip, turns, doubts = made_upright(read, roles, asked.up or parsed.up)
    if asked.skip_frames == 0 and _starts_with_a_pose(clip.rotations):
        warnings.append("the first frame looks like a bind pose; leave it out with --skip-frames 1, or in clips.toml")
    warnings += doubts + check_shape(clip, roles, given=bool(given), up_known=asked.up is not None or clip is not read)
    if asked.mirror:
        pose = standing_pose(clip.skeleton, roles, clip)
        clip = Mirror.of(clip.skeleton, roles, pose).clip(clip)
    return Reading(clip, roles, metres, (*notes, *turns), tuple(warnings))


def root_of(nodes: Nodes, above: str | None, given: Mapping[str, GivenRole]) -> int:
    """Returns the joint at which legs and trunk branch, of the body below the joint called `above`, if one is named.

    If names do not show it, returns that joint or the file's own root; `find_roles` then reports what is missing.
    Raises RoleError if a limb is not a chain of joints, as in rigs whose feet hang on IK targets.
    """
    if above is not None and above not in nodes.names:
        raise RoleError(f"unknown joint {above!r} for --root", mend=did_you_mean(above, nodes.names))
    body = subtree(nodes.parents, nodes.names.index(above) if above else 0)
    names = tuple(nodes.names[joint] for joint in body)
    found = {role: body[joint] for role, joint in limbs_by_name(names, given).items()}
    if set(LIMBS) <= set(found):
        check_limbs(nodes.names, nodes.parents, found)
    return common_ancestor(nodes.parents, [found[role] for role in ENDS]) if set(ENDS) <= set(found) else body[0]


def _other_body(nodes: Nodes, read: tuple[str, ...]) -> list[str]:
    """Returns a note if the joints that are not read have legs and arms too."""
    inside = set(read)
    names = tuple(name for name in nodes.names if name not in inside)
    found = limbs_by_name(names, NOTHING_GIVEN)
    if not set(ENDS) <= set(found):
        return []
    other = common_ancestor(nodes.parents, [nodes.names.index(names[found[role]]) for role in ENDS])
    return [f"read the skeleton {read[0]!r}; choose another with --root: {nodes.names[other]}"]


def _clip(name: str, folded: Folded, rate: float, metres: float, skip: int) -> Clip:
    positions = folded.root_positions[skip:] * metres
    return Clip(name, shared(folded.skeleton.scaled(metres)), rate, positions, folded.rotations[skip:])


def _starts_with_a_pose(rotations: Floats) -> bool:
    if len(rotations) < 4:
        return False
    first = quaternion.angle(rotations[0], rotations[1]).mean()
    if first <= JUMP:  # true of nearly all files, and then the other frames need not be read
        return False
    return bool(first > 2.0 * np.max(quaternion.angle(rotations[1:-1], rotations[2:]).mean(axis=1)))
