"""The OpenAPI document: FastAPI's part, and the direct route's, generated from the lists that check its queries."""

from __future__ import annotations

from typing import Any, get_args

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from motionsplice import __version__
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.requests import Posture
from motionsplice.service.answers.pose import POSE
from motionsplice.service.answers.poses import POSES
from motionsplice.service.answers.splice import FILES, SPLICE
from motionsplice.service.answers.stream import MEDIA_TYPE as STREAM_TYPE
from motionsplice.service.answers.stream import STREAM
from motionsplice.service.characters.hub import CHARACTERS
from motionsplice.service.models import BankInfo, ClipInfo, ServerInfo, SkeletonInfo
from motionsplice.service.problems import Problem
from motionsplice.service.routes import NOT_READY, REFUSED, UNKNOWN, Responses, problem_response
from motionsplice.service.shared import Shared
from motionsplice.service.wire.axes import AXES
from motionsplice.service.wire.messages import JSON, MSGPACK
from motionsplice.service.wire.query import REQUIRED, Query

ABOUT = """Splices the upper body of any clip onto the lower body of any other.

Right-handed, Y up, characters face Z; metres, seconds, unit quaternions xyzw. `axes` selects another engine's axes and
units. Rotations are in the parent's frame, the root's in the world. Everything that depends only on the bank is also
available below `/v1/banks/{digest}`, where caches may keep it for ever. `docs/protocol.md` describes the bytes."""
OCTETS = {"type": "string", "format": "binary"}
NOT_MODIFIED: Responses = {304: {"description": "The client's cached copy is current"}}
BUSY = problem_response(429, "Too many streams at once")
LIMITED = problem_response(422, "An invalid parameter, or more than the service allows")


def document(app: FastAPI, shared: Shared) -> dict[str, Any]:
    """Returns the document. Its examples are requests that the served bank can answer."""
    if app.openapi_schema is None:
        schema = get_openapi(title=app.title, version=__version__, description=ABOUT, routes=app.routes)
        schema["components"]["schemas"]["Problem"] = Problem.model_json_schema()
        schema["components"]["schemas"]["Frames"] = FRAMES
        schema["components"]["schemas"]["Batch"] = BATCH
        schema["paths"] |= _direct(shared.serving.bank)
        schema["paths"] = dict(sorted(schema["paths"].items()))
        if shared.settings.token is not None:
            schema["components"]["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
            schema["security"] = [{"token": []}]
        _fill_in(schema["paths"], shared)
        app.openapi_schema = schema
    return app.openapi_schema


FRAMES = {
    "type": "object",
    "example": {
        "bank": "b6093d240d320be34211b036cccaa68d",
        "root_positions": [0.603, 0.964, 1.602],
        "rotations": [[0.032, 0.314, -0.006, 0.949], [-0.067, 0.022, -0.012, 0.997]],
    },
    "title": "Frames",
    "description": "F frames of n characters with J joints (docs/protocol.md, Frames). F and n are left out where they "
    "are always one. In MessagePack, arrays are blobs of little-endian numbers.",
    "required": ["bank", "root_positions"],
    "properties": {
        "bank": {"type": "string", "description": "digest"},
        "frame": {"type": "integer", "description": "number of the first frame"},
        "count": {"type": "integer", "description": "number of frames"},
        "rate": {"type": "number", "description": "frames per second"},
        "root_positions": {"type": "array", "items": {}, "description": "[F, n, 3] float32"},
        "rotations": {"type": "array", "items": {}, "description": "[F, n, J, 4] float32 or int16"},
        "world_positions": {"type": "array", "items": {}, "description": "[F, n, J, 3] float32"},
    },
}
BATCH = {
    "type": "object",
    "title": "Batch",
    "additionalProperties": False,
    "required": ["clips", "locomotion", "time"],
    "properties": {
        "clips": {"type": "array", "items": {"type": "string"}},
        "locomotion": {"type": "array", "items": {"type": "integer"}, "description": "[n] indices into clips"},
        "time": {"type": "array", "items": {"type": "number"}, "description": "[n] seconds into the locomotion"},
        "action": {"type": "array", "items": {"type": "integer"}, "description": "[n] indices into clips; -1: none"},
        "hands": {"type": "array", "items": {"type": "integer"}, "description": "[n] indices into clips; -1: its own"},
        "start": {"type": "array", "items": {"type": "number"}, "description": "[n] seconds into the action"},
        "method": {"type": "string", "enum": ["splice", "naive", "none"]},
        "posture": {"type": "string", "enum": [posture for posture in get_args(Posture) if posture != "running"]},
    },
}


def _direct(bank: Bank) -> dict[str, Any]:
    """Returns the operations of the direct route, which FastAPI does not know."""
    frames = {JSON: {"schema": {"$ref": "#/components/schemas/Frames"}}, MSGPACK: {"schema": OCTETS}}
    batch = _batch_example(bank)
    return {
        "/v1/pose": {
            "get": {
                **_about("One pose", "The splice at one moment. It costs the same anywhere in a clip."),
                "operationId": "get_pose",
                "parameters": _parameters(POSE),
                "responses": _responses(frames, NOT_MODIFIED, UNKNOWN, REFUSED, NOT_READY),
            }
        },
        "/v1/poses": {
            "post": {
                **_about("Poses of many characters", "The request that a game sends every tick."),
                "operationId": "post_poses",
                "parameters": _parameters(POSES),
                "requestBody": {
                    "required": True,
                    "content": {
                        JSON: {"schema": {"$ref": "#/components/schemas/Batch"}, "example": batch},
                        MSGPACK: {"schema": OCTETS},
                    },
                },
                "responses": _responses(
                    frames,
                    UNKNOWN,
                    LIMITED,
                    NOT_READY,
                    problem_response(408, "The body did not arrive"),
                    problem_response(413, "The body is too large"),
                    problem_response(415, "A body of an unsupported type"),
                ),
            }
        },
        "/v1/splice": {
            "get": {
                **_about("A whole splice", "All frames, or a range of them, in one cacheable answer."),
                "operationId": "get_splice",
                "parameters": _parameters(SPLICE),
                "responses": _responses(
                    {**frames, **{form.decode(): {"schema": OCTETS} for form in FILES.values()}},
                    NOT_MODIFIED,
                    UNKNOWN,
                    LIMITED,
                    BUSY,
                    NOT_READY,
                ),
            }
        },
        "/v1/stream": {
            "get": {
                **_about(
                    "A splice as a stream",
                    "Length-delimited messages (four bytes, big-endian): a header, then maps of `ahead` frames "
                    "each, in MessagePack.",
                ),
                "operationId": "get_stream",
                "parameters": _parameters(STREAM),
                "responses": _responses({STREAM_TYPE.decode(): {"schema": OCTETS}}, UNKNOWN, LIMITED, BUSY, NOT_READY),
            }
        },
        "/v1/characters": {
            "get": {
                **_about(
                    "Characters over a WebSocket",
                    "Commands are JSON text, frames are MessagePack or JSON. A request without an upgrade to a "
                    "WebSocket is a 404.",
                ),
                "operationId": "characters",
                "parameters": _parameters(CHARACTERS),
                "responses": {
                    "101": {"description": "The handshake is accepted"},
                    **_responses(None, problem_response(404, "No WebSocket handshake"), LIMITED, BUSY, NOT_READY),
                },
            }
        },
    }


def _about(summary: str, description: str) -> dict[str, Any]:
    return {"tags": ["motion"], "summary": summary, "description": description}


def _parameters(query: Query) -> list[dict[str, Any]]:
    return [
        {
            "name": one.name,
            "in": "query",
            "required": one.default is REQUIRED,
            "description": one.description[0].upper() + one.description[1:],
            "schema": dict(one.schema),
        }
        for one in query.parameters.values()
    ]


def _responses(content: dict[str, Any] | None, *others: Responses) -> dict[str, Any]:
    good = {"200": {"description": "The frames", "content": content}} if content else {}
    return good | {str(status): response for one in others for status, response in one.items()}


def _fill_in(paths: dict[str, Any], shared: Shared) -> None:
    """Adds examples from the served bank to the parameters and answers."""
    bank = shared.serving.bank
    locomotion, action = _clips(bank)
    examples = {"name": locomotion, "locomotion": locomotion, "action": action, "time": 0.5, "count": 10, "rate": 30}
    for path, operations in paths.items():
        for parameter in operations.get("get", {}).get("parameters", []):
            if (name := parameter["name"]) in examples:
                parameter["example"] = "postures" if path == "/v1/tables/{name}" else examples[name]
    clip = ClipInfo.of(bank, bank.clip(locomotion))
    for path, answer in (
        ("/v1/server", ServerInfo.of(bank, shared.settings, ready=True)),
        ("/v1/bank", BankInfo.of(bank)),
        ("/v1/skeleton", SkeletonInfo.of(bank, AXES["gltf"])),
        ("/v1/clips/{name}", clip),
    ):
        _answer(paths, path)["example"] = answer.model_dump()
    _answer(paths, "/v1/clips")["example"] = [clip.model_dump()]


def _answer(paths: dict[str, Any], path: str) -> dict[str, Any]:
    content: dict[str, Any] = paths[path]["get"]["responses"]["200"]["content"][JSON]
    return content


def _clips(bank: Bank) -> tuple[str, str]:
    first = {clip.kind: clip.name for clip in reversed(bank.clips)}
    return first.get("locomotion", bank.clips[0].name), first.get("action", bank.clips[0].name)


def _batch_example(bank: Bank) -> dict[str, Any]:
    return {"clips": list(_clips(bank)), "locomotion": [0, 0], "time": [0.5, 1.0], "action": [1, -1]}
