"""Reads `clips.toml`: what the offline job needs to know about clips, beyond their motion files.

[walk_box]
kind = "action"          # or "locomotion", the default
neutral = "walk"         # the clip that its posture is relative to
mask = "right_arm"       # the parts that an action without a gait poses; measured if left out
tags = ["carry"]
skip_frames = 1          # leading frames that are not motion, such as a T-pose
unit = "cm"
up = "z"                 # the axis that is up in the file, where it is not found
rate = 120               # frames per second, if the file says it wrongly
root = "Hips2"           # a joint of the body to read, in a file with several
mirror = true            # exchange left and right
roles = "odd.toml"       # a roles file beside this one, for a rig whose joint names are not known

[moves]                  # all animations of moves.glb
unit = "cm"

["moves:run"]            # one of them; it has the keys of [moves] too
kind = "action"
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from motionsplice.motion.errors import SettingsError, did_you_mean
from motionsplice.motion.parts import MASKS
from motionsplice.motion.roles import GivenRole, read_roles_file
from motionsplice.motion.storage.place import Place
from motionsplice.motion.toml_file import read_toml

FILE_NAME = "clips.toml"
KINDS = ("locomotion", "action")
AXES = ("x", "y", "z", "-x", "-y", "-z")  # those that may be up
VALUES = {
    "kind": '"locomotion" or "action"',
    "neutral": "the name of a clip, in quotes",
    "mask": ", ".join(f'"{name}"' for name in MASKS),
    "tags": 'a list of strings, such as ["carry"]',
    "skip_frames": "a whole number, 0 or more",
    "unit": '"m", "cm" or another name of a unit, or the metres in it, such as 0.01',
    "up": '"x", "y", "z", "-x", "-y" or "-z"',
    "rate": "a number above 0",
    "root": "the name of a joint, in quotes",
    "mirror": "true or false",
    "roles": "the name of a roles file beside clips.toml, in quotes",
}


@dataclass(frozen=True)
class ClipSettings:
    """The settings of one clip: its table in `clips.toml`.

    Attributes:
        kind: "locomotion" or "action".
        neutral: The name of the clip that this clip's posture is relative to; None for the locomotion nearest
            in gait.
        mask: The parts that an action without a gait poses alone, one of `MASKS`; None to measure them.
        tags: Any words, which the bank stores with the clip.
        skip_frames: The number of leading frames to leave out because they are not motion, such as a T-pose.
        unit: The file's unit of length, as `read_clip` takes it; None to take it from the file or guess it.
        up: The axis that is up in the file, as `read_clip` takes it.
        rate: Frames per second, if the file states it wrongly.
        root: The root of the body to read, in a file with several.
        mirror: Whether left and right are exchanged.
        roles: Joint names by role, for joints that cannot be found by name.
    """

    kind: str = "locomotion"
    neutral: str | None = None
    tags: tuple[str, ...] = ()
    skip_frames: int = 0
    unit: str | None = None
    up: str | None = None
    rate: float | None = None
    root: str | None = None
    mirror: bool = False
    mask: str | None = None
    roles: Mapping[str, GivenRole] = field(default_factory=dict)

    @property
    def reading(self) -> dict[str, Any]:
        """The arguments for `read_clip`."""
        return {key: getattr(self, key) for key in ("skip_frames", "unit", "up", "rate", "root", "mirror", "roles")}


DEFAULT_SETTINGS = ClipSettings()


def read_clip_settings(file: Place, default: ClipSettings = DEFAULT_SETTINGS) -> dict[str, ClipSettings]:
    """Reads a `clips.toml`.

    Args:
        file: The file.
        default: The settings that the file leaves out.

    Returns:
        Settings by the name of a clip, or of a file with several; `settings_for` finds those of a clip.

    Raises:
        SettingsError: The file cannot be read or is not TOML, or a key or value is invalid. The message names the clip
            and the key.
    """
    entries = read_toml(file)
    return {name: _settings(name, _with_those_of_file(name, entries), file, default) for name in entries}


def settings_for(clip: str, settings: Mapping[str, ClipSettings], default: ClipSettings) -> ClipSettings:
    """Returns a clip's own settings, else those of its file, else `default`."""
    return settings.get(clip) or settings.get(clip.partition(":")[0], default)


def _with_those_of_file(name: str, entries: Mapping[str, Any]) -> Any:
    own, shared = entries[name], entries.get(name.partition(":")[0])
    return {**shared, **own} if isinstance(own, Mapping) and isinstance(shared, Mapping) else own


def _settings(name: str, entry: Any, file: Place, default: ClipSettings) -> ClipSettings:
    where = f"clip {name!r}"
    if not isinstance(entry, Mapping):
        raise SettingsError(
            f"expected a table, found {entry!r:.80}", file=str(file), place=where, mend=f"Begin it with [{name}]"
        )
    keys = [field.name for field in fields(ClipSettings)]
    for key in entry:
        if key not in keys:
            mend = _without_suffix(name) if isinstance(entry[key], Mapping) else did_you_mean(key, keys)
            raise SettingsError(f"unknown key {key!r:.80}", file=str(file), place=where, mend=mend)
    tags, roles = entry.get("tags", list(default.tags)), entry.get("roles")
    given = {key: entry[key] for key in entry if key != "roles"}
    if _is_positive(unit := entry.get("unit")):
        given["unit"] = str(unit)
    settings = replace(default, **{**given, "tags": tuple(tags) if isinstance(tags, list) else ()})
    invalid = [
        key
        for key, valid in {
            "kind": settings.kind in KINDS,
            "neutral": isinstance(settings.neutral, str | None),
            "mask": settings.mask is None or (isinstance(settings.mask, str) and settings.mask in MASKS),
            "tags": isinstance(tags, list) and all(isinstance(tag, str) for tag in settings.tags),
            "skip_frames": type(settings.skip_frames) is int and settings.skip_frames >= 0,
            "unit": isinstance(settings.unit, str | None),
            "up": settings.up in (None, *AXES),
            "rate": settings.rate is None or _is_positive(settings.rate),
            "root": isinstance(settings.root, str | None),
            "mirror": isinstance(settings.mirror, bool),
            "roles": isinstance(roles, str | None),
        }.items()
        if key in entry and not valid
    ]
    if invalid:
        key = invalid[0]
        raise SettingsError(
            f"invalid value {key} = {entry[key]!r:.80}", file=str(file), place=where, mend=f"Use {VALUES[key]}"
        )
    return replace(settings, roles=_roles(file, roles, where)) if roles else settings


def _is_positive(value: Any) -> bool:
    return type(value) in (int, float) and 0.0 < value < math.inf


def _without_suffix(name: str) -> str:
    """Returns what to do about `[walk.fbx]`, which is a table in a table."""
    return f'Write [{name}], without the suffix of a file. A name with a point stands in quotes, as ["{name}.v2"]'


def _roles(file: Place, name: str, where: str) -> Mapping[str, GivenRole]:
    try:
        return read_roles_file(file.parent / name)
    except SettingsError as error:
        raise SettingsError(error.problem, file=str(file), place=f"{where}, {name}", mend=error.mend) from None
