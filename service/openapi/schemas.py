"""Schemas of what the direct route reads and writes: enumerations, frames, and a batch of poses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

from motionsplice.motion.axes import AxesName
from motionsplice.runtime.characters.state import EVENT_NAMES
from motionsplice.runtime.requests import Method, Posture
from motionsplice.service.answers.batch import NAMES
from motionsplice.service.answers.pose import POSE
from motionsplice.service.answers.splice import SPLICE
from motionsplice.service.answers.stream import STREAM
from motionsplice.service.problems import Problem
from motionsplice.service.wire.encoding import NUMBERS, PARTS
from motionsplice.service.wire.query import Query

Schema = dict[str, Any]

ANY = None  # any length of a list
NONE: Mapping[str, Schema] = {}
_BANK: Schema = {"type": "string", "description": "Digest of the bank", "example": "b6093d240d320be34211b036cccaa68d"}


def reference(name: str) -> Schema:
    """Returns a reference to a schema of `SCHEMAS`."""
    return {"$ref": f"#/components/schemas/{name}"}


def _values(query: Query, name: str) -> tuple[str, ...]:
    return tuple(query.parameters[name].schema["enum"])


ENUMERATIONS: Mapping[tuple[str, ...], str] = {
    get_args(AxesName): "Axes",
    NUMBERS: "Encoding",
    PARTS: "Parts",
    get_args(Method): "Method",
    get_args(Posture): "Posture",
    NAMES["posture"]: "BatchPosture",
    _values(POSE, "format"): "Format",
    _values(SPLICE, "format"): "SpliceFormat",
    _values(STREAM, "pace"): "Pace",
    ("locomotion", "action"): "Kind",
}


def with_named_enumerations(schema: Any) -> Any:
    """Returns a part of the document with references to `ENUMERATIONS`, so that a client has each of them once."""
    if isinstance(schema, list):
        return [with_named_enumerations(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    name = ENUMERATIONS.get(tuple(schema["enum"])) if isinstance(schema.get("enum"), list) else None
    if name is None:
        return {key: with_named_enumerations(one) for key, one in schema.items()}
    others = {key: one for key, one in schema.items() if key not in ("type", "enum", "title")}
    return {**reference(name), **others}


def _numbers(*lengths: int | None) -> Schema:
    """Returns the schema of nested lists of numbers, the outermost first."""
    schema: Schema = {"type": "number"}
    for length in reversed(lengths):
        fixed = {} if length is ANY else {"minItems": length, "maxItems": length}
        schema = {"type": "array", "items": schema, **fixed}
    return schema


def _frames(
    title: str, description: str, *leading: None, optional: Mapping[str, Schema] = NONE, **fields: Schema
) -> Schema:
    """Returns the schema of a map of frames, whose arrays have the dimensions `leading` before their own."""
    example: list[Any] = [[0.603, 0.964, 1.602], [[0.032, 0.314, -0.006, 0.949], [-0.067, 0.022, -0.012, 0.997]]]
    root, rotations = [[one] for one in example] if leading else example
    return {
        "type": "object",
        "title": title,
        "description": f"{description} (docs/protocol.md, Frames). J joints; `parts` selects the arrays.",
        "required": ["bank", *fields, "root_positions"],
        "properties": {
            "bank": _BANK,
            **fields,
            "root_positions": {**_numbers(*leading, 3), "example": root},
            "rotations": {**_numbers(*leading, ANY, 4), "example": rotations},
            "world_positions": _numbers(*leading, ANY, 3),
            **optional,
        },
    }


def _indices(description: str) -> Schema:
    return {"type": "array", "items": {"type": "integer"}, "description": f"[n] indices into clips{description}"}


def _seconds(description: str) -> Schema:
    return {"type": "array", "items": {"type": "number"}, "description": f"[n] seconds into the {description}"}


_OF_RIG: dict[str, Schema] = {
    "rig": reference("TakeRig"),
    "node_translations": _numbers(ANY, ANY, 3),
    "node_rotations": _numbers(ANY, ANY, 4),
}
_FRAMES: dict[str, Schema] = {
    "frame": {"type": "integer", "description": "Number of the first frame"},
    "count": {"type": "integer", "description": "F"},
    "rate": {"type": "number", "description": "Frames per second"},
}
_ESTIMATES = {
    "error": "Expected distance of the upper body from that of the same person doing both",
    "replaced": "The same for plain replacement",
    "ratio": "error / replaced",
    "legs": "Distance of root and knees of both clips at the frames that are spliced",
    "repetition": "Distance of the action's upper body from itself a stride later; 0: unknown",
    "slowest": "Least speed of the action, seconds of the action per second",
    "fastest": "Largest speed of the action",
}
SCHEMAS: Mapping[str, Schema] = {
    **{name: {"type": "string", "title": name, "enum": list(values)} for values, name in ENUMERATIONS.items()},
    "Problem": Problem.model_json_schema(),
    "Pose": _frames("Pose", "One frame of one character"),
    "Poses": _frames("Poses", "One frame of n characters: lists [n, ...]", ANY),
    "Frames": _frames("Frames", "F frames of one character: lists [F, ...]", ANY, **_FRAMES),
    "Take": _frames(
        "Take",
        "F frames of one character: lists [F, ...]",
        ANY,
        **_FRAMES,
        phases={**_numbers(ANY), "description": "[F] phase of the locomotion, in strides"},
        action_times={
            "type": "array",
            "items": {"anyOf": [{"type": "number"}, {"type": "null"}]},
            "description": "[F] seconds into the action; null without one",
        },
        events={"type": "array", "items": reference("TakeEvent"), "description": "What happened, in order"},
        optional=_OF_RIG,
    ),
    "ExpectationAnswer": {
        "type": "object",
        "title": "ExpectationAnswer",
        "description": "What to expect of a splice",
        "required": ["bank", "expected"],
        "properties": {
            "bank": _BANK,
            "expected": {
                "anyOf": [reference("Expectation"), {"type": "null"}],
                "description": "Null for an action that stands or has stretches, whose time does not follow the legs",
            },
        },
    },
    "Expectation": {
        "type": "object",
        "title": "Expectation",
        "description": "Estimates from what both clips show. Distances are means over frames and joints, metres.",
        "required": [*_ESTIMATES, "gains_little"],
        "properties": {
            **{name: {"type": "number", "description": meaning} for name, meaning in _ESTIMATES.items()},
            "gains_little": {
                "type": "boolean",
                "description": "Whether plain replacement may be as good, and the splice is not good itself",
            },
        },
    },
    "TakeRig": {
        "type": "object",
        "title": "TakeRig",
        "description": "The nodes of a rig that a take was put onto",
        "required": ["scale", "moved", "turned", "still", "notes"],
        "properties": {
            "scale": {"type": "number", "description": "Metres in a unit of the rig, for legs as long as the bank's"},
            "moved": {"type": "array", "items": {"type": "integer"}, "description": "[M] nodes of node_translations"},
            "turned": {"type": "array", "items": {"type": "integer"}, "description": "[N] nodes of node_rotations"},
            "still": {
                "type": "array",
                "items": {"type": "object", "additionalProperties": True},
                "description": "Values of the other nodes: `node`, and its `translation` or `rotation`",
            },
            "notes": {"type": "array", "items": {"type": "string"}, "description": "What the rig does not show"},
        },
    },
    "TakeEvent": {
        "type": "object",
        "title": "TakeEvent",
        "description": "An event of a take",
        "required": ["frame", "event"],
        "properties": {
            "frame": {"type": "integer", "description": "The first frame that shows it"},
            "event": {"type": "string", "enum": list(EVENT_NAMES.values())},
            "action": {"type": "string", "description": "The clip of an action"},
        },
    },
    "TakeOrder": {
        "type": "object",
        "title": "TakeOrder",
        "description": "What a character is to do",
        "additionalProperties": False,
        "required": ["frames", "commands"],
        "properties": {
            "rate": {"type": "number", "default": 60.0, "description": "Frames per second"},
            "frames": {"type": "integer", "description": "F"},
            "commands": {
                "type": "array",
                "items": {"type": "object", "additionalProperties": True},
                "description": "Commands of the WebSocket without `id`; `at` is the frame at which each is done",
            },
            "rig": {"type": "string", "description": "A GLB file with a character's nodes and skins, in base64"},
        },
    },
    "Batch": {
        "type": "object",
        "title": "Batch",
        "description": "What n characters play",
        "additionalProperties": False,
        "required": ["clips", "locomotion", "time"],
        "properties": {
            "clips": {"type": "array", "items": {"type": "string"}},
            "locomotion": _indices(""),
            "time": _seconds("locomotion"),
            "action": _indices("; -1: none"),
            "hands": _indices("; -1: its own"),
            "start": _seconds("action"),
            "method": reference("Method"),
            "posture": reference("BatchPosture"),
        },
    },
}
