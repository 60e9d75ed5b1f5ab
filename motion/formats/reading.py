"""Reads a motion file of any supported format as a clip, with the roles of its joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats.files import SCENES, clip_name, parse
from motionsplice.motion.formats.fold import Folded, Nodes, fold
from motionsplice.motion.formats.units import guess_unit, metres_per_unit
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import (
    ENDS,
    NOTHING_GIVEN,
    GivenRole,
    Roles,
    check_shape,
    common_ancestor,
    find_roles,
    limbs_by_name,
)

# The first frame is a bind pose if the step after it, in mean radians over the joints, exceeds this and is more than
# twice as large as any other step.
JUMP = 0.1

SHORTEST_LEG, LONGEST_LEG = 0.3, 2.5  # metres: with other legs, a glTF or FBX file is not in the unit that it states
CHECKED_RATE = 10.0  # frames per second at which the roles are checked against the motion


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
    path: str | PathLike[str],
    *,
    animation: str | None = None,
    skip_frames: int = 0,
    unit: str | None = None,
    roles: Mapping[str, GivenRole] = NOTHING_GIVEN,
) -> Reading:
    """Reads a BVH, AMC, FBX or glTF file (.glb, .gltf, .vrm, .vrma).

    FBX files need the extra `motionsplice[fbx]`.
    The skeleton of an AMC file is the ASF file in the same folder: `16.asf` for `16_15.amc`, or else the only one.
    Joints above the root, at which legs and trunk branch, are folded into its motion; joints that do not descend
    from it are left out.

    Args:
        path: The file.
        animation: The name of the animation, for a glTF or FBX file that has several.
        skip_frames: The number of leading frames to leave out because they are not motion, such as a T-pose.
        unit: The file's unit of length: "m", "dm", "cm", "mm", "in", "cmu" (0.0254 / 0.45 m), or metres per unit as a
            number. None to use the one stated in the file, or else the one that gives the legs an adult's length.
        roles: Joint names by role, for joints that cannot be found by name; see `find_roles`.

    Returns:
        The clip, its roles, and notes and warnings for the user.

    Raises:
        FormatError: The file or its skeleton file is missing, malformed or of an unsupported type.
        ClipError: The motion is invalid, for example not finite.
        RoleError: The roles of the joints cannot be found.
        SettingsError: The unit or a role is unknown.

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
    path = Path(path)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # Skeleton and Clip reject numbers that are not finite
            return _read(path, animation, skip_frames, unit, roles)
    except MotionError as error:
        raise error.within(str(path)) from None


def _read(
    path: Path, animation: str | None, skip_frames: int, unit: str | None, given: Mapping[str, GivenRole]
) -> Reading:
    nodes, rate, own_unit, own_roles, own_notes, own_warnings = parse(path, animation)
    given = {**own_roles, **given}
    if not 0 <= skip_frames < len(nodes.rotations):
        problem = f"cannot skip {skip_frames} of {len(nodes.rotations)} frames"
        raise FormatError(problem, mend="Choose a smaller --skip-frames")
    folded = fold(nodes, root_of(nodes, given))
    roles = find_roles(folded.skeleton, given)
    notes = [*own_notes, *folded.notes]
    leg = roles.leg_length(folded.skeleton)
    if unit is not None:
        metres = metres_per_unit(unit)
    elif own_unit is not None and (path.suffix.lower() not in SCENES or SHORTEST_LEG <= own_unit * leg <= LONGEST_LEG):
        metres = own_unit
    else:
        metres, note = guess_unit(leg)
        notes.append(note)
    clip = _clip(clip_name(path, animation), folded, rate, metres, skip_frames)
    posed = skip_frames == 0 and _starts_with_a_pose(clip.rotations)
    warnings = ("the first frame looks like a bind pose; leave it out with --skip-frames 1",) if posed else ()
    if not given:
        checked = slice(None, None, max(1, int(clip.rate / CHECKED_RATE)))
        check_shape(world_transforms(clip.skeleton, clip.root_positions[checked], clip.rotations[checked])[0], roles)
    return Reading(clip, roles, metres, tuple(notes), (*own_warnings, *warnings))


def root_of(nodes: Nodes, given: Mapping[str, GivenRole]) -> int:
    """Returns the joint at which legs and trunk branch.

    If names do not show it, returns the file's own root; `find_roles` then reports what is missing.
    """
    found = limbs_by_name(nodes.names, given)
    return common_ancestor(nodes.parents, [found[role] for role in ENDS]) if set(ENDS) <= set(found) else 0


def _clip(name: str, folded: Folded, rate: float, metres: float, skip: int) -> Clip:
    positions = folded.root_positions[skip:] * metres
    return Clip(name, folded.skeleton.scaled(metres), rate, positions, folded.rotations[skip:])


def _starts_with_a_pose(rotations: Floats) -> bool:
    if len(rotations) < 4:
        return False
    first = quaternion.angle(rotations[0], rotations[1]).mean()
    if first <= JUMP:  # true of nearly all files, and then the other frames need not be read
        return False
    return bool(first > 2.0 * np.max(quaternion.angle(rotations[1:-1], rotations[2:]).mean(axis=1)))
