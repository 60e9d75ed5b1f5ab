"""Query parameters that several operations share (docs/protocol.md, "Parameters")."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, get_args

from motionsplice.motion.axes import AXES
from motionsplice.runtime.requests import Method, Posture
from motionsplice.runtime.splice import Splice
from motionsplice.service.wire.encoding import NUMBERS, PARTS, Encoding
from motionsplice.service.wire.query import REQUIRED, Parameter, choice, number, text


def _posture(among: Sequence[str]) -> Parameter:
    return choice("posture", "how the action's posture is kept", among, "relative")


WHAT = (
    text("locomotion", "clip that gives the root and the lower body", REQUIRED),
    text("action", "clip that gives the upper body; default: the locomotion alone"),
    number("start", "earliest second of the action; it begins at the next frame in step", 0.0),
    choice(
        "method",
        "`naive` replaces the upper body's rotations; `none` is the locomotion alone",
        get_args(Method),
        "splice",
    ),
    text("hands", "hands clip to lay on the clip that gives the upper body; default: that clip's own hands"),
    _posture(get_args(Posture)),
)
POSTURES_OF_A_MOMENT = tuple(one for one in get_args(Posture) if one != "running")  # which depends on earlier frames
WHAT_AT_A_MOMENT = (*(one for one in WHAT if one.name != "posture"), _posture(POSTURES_OF_A_MOMENT))
HOW = (
    choice("axes", "engine whose axes and unit are used", tuple(AXES), "gltf"),
    choice("parts", "local rotations, world positions of all joints, or both", PARTS, "local"),
    choice("encoding", "number format of rotations", NUMBERS, "float32"),
)


def format_parameter(*formats: str) -> Parameter:
    """Returns the parameter `format`. The first of `formats` is the default."""
    return choice("format", "JSON for people, MessagePack for engines", formats, formats[0])


def splice_of(values: Mapping[str, Any]) -> Splice:
    """Returns the splice of a query that has the parameters WHAT or WHAT_AT_A_MOMENT."""
    return Splice(**{parameter.name: values[parameter.name] for parameter in WHAT})


def encoding(values: dict[str, Any]) -> Encoding:
    """Returns the encoding of a query that has the parameters HOW."""
    return Encoding(AXES[values["axes"]], values["encoding"], values["parts"])
