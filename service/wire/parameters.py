"""The parameters that operations share (docs/protocol.md, "Parameters")."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

from motionsplice.runtime.requests import Method, Posture
from motionsplice.runtime.splice import Splice
from motionsplice.service.wire.axes import AXES
from motionsplice.service.wire.encoding import NUMBERS, PARTS, Encoding
from motionsplice.service.wire.query import REQUIRED, Parameter, choice, number, text

WHAT = (
    text("locomotion", "the clip that gives root and lower body", REQUIRED),
    text("action", "the clip that gives the upper body; without it, the locomotion alone"),
    number("start", "seconds into the action before which it does not begin", 0.0),
    choice("method", "`naive` is plain replacement of the upper body's joints", get_args(Method), "splice"),
    text("hands", "the hands that are laid on the clip that gives the upper body; without it, its own"),
    choice("posture", "what becomes of the action's posture", get_args(Posture), "relative"),
)
HOW = (
    choice("axes", "axes and units of which engine", tuple(AXES), "gltf"),
    choice("parts", "local rotations, world positions of all joints, or both", PARTS, "local"),
    choice("encoding", "numbers that rotations come as", NUMBERS, "float32"),
)


def format_parameter(*formats: str) -> Parameter:
    """The form of an answer; the first is the default."""
    return choice("format", "JSON for people, MessagePack for engines", formats, formats[0])


def splice_of(values: Mapping[str, Any]) -> Splice:
    """What is spliced, of the values of a query with the parameters WHAT."""
    return Splice(**{parameter.name: values[parameter.name] for parameter in WHAT})


def encoding(values: dict[str, Any]) -> Encoding:
    """How frames are to be encoded."""
    return Encoding(AXES[values["axes"]], values["encoding"], values["parts"])
